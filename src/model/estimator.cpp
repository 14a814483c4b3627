#include "model/estimator.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "base/statistics.h"

namespace ctn::model {
namespace {

constexpr std::size_t kFrequencyWindows = 10;

// Returns what it replaced; `value` itself while there is room.
template <class Ring, class T>
T push(Ring& ring, T value, std::size_t capacity) {
  if (ring.values.size() < capacity) {
    ring.values.push_back(value);
    return value;
  }
  const T replaced = std::exchange(ring.values[ring.oldest], value);
  ring.oldest = (ring.oldest + 1) % capacity;
  return replaced;
}

}  // namespace

Estimator::Estimator(int window, double percentile, std::vector<std::string> modes)
    : window_(static_cast<std::size_t>(window)), percentile_(percentile), names_(std::move(modes)) {
  assert(window >= 1 && percentile > 0.0 && percentile <= 100.0);
  if (names_.empty()) names_.emplace_back();
  runs_.resize(names_.size());
  recent_count_.resize(names_.size());
}

void Estimator::add(Nanos cpu, std::size_t mode) {
  assert(cpu.count() >= 0);
  if (mode >= names_.size()) mode = 0;
  push(runs_[mode], cpu, window_);

  const std::size_t capacity = window_ * kFrequencyWindows;
  const bool full = recent_modes_.values.size() == capacity;
  const std::size_t replaced = push(recent_modes_, mode, capacity);
  if (full) --recent_count_[replaced];
  ++recent_count_[mode];
  ++count_;
}

CostProfile Estimator::profile(double percentile) const {
  assert(count_ > 0);
  const auto total = static_cast<double>(recent_modes_.values.size());
  std::vector<ModeCost> modes;
  modes.reserve(names_.size());
  for (std::size_t mode = 0; mode < names_.size(); ++mode) {
    std::vector<double> samples;
    samples.reserve(runs_[mode].values.size());
    for (const Nanos run : runs_[mode].values) samples.push_back(to_millis(run).count());
    std::sort(samples.begin(), samples.end());
    const double cost = samples.empty() ? 0.0 : percentile_of_sorted(samples, percentile);
    modes.push_back({names_[mode], static_cast<double>(recent_count_[mode]) / total, Millis{cost}});
  }
  return CostProfile::of_modes(std::move(modes));
}

}  // namespace ctn::model
