#include "model/estimator.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <utility>

#include "base/statistics.h"

namespace ctn::model {
namespace {

constexpr std::size_t kFrequencyWindows = 10;
constexpr std::size_t kSampledWindows = 4;
// So many runs of a mode suffice after invalidate(); then what was seen before is forgotten.
constexpr std::size_t kMinSamples = 5;

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

// 0 where there are none.
Millis percentile_of(std::span<const RunTime> runs, double percentile, Nanos RunTime::*what = &RunTime::cpu) {
  if (runs.empty()) return Millis{0};
  std::vector<double> samples;
  samples.reserve(runs.size());
  for (const RunTime& run : runs) samples.push_back(to_millis(run.*what).count());
  std::sort(samples.begin(), samples.end());
  return Millis{percentile_of_sorted(samples, percentile)};
}

}  // namespace

Estimator::Estimator(int window, double percentile, std::vector<std::string> modes)
    : window_(static_cast<std::size_t>(window)), percentile_(percentile), names_(std::move(modes)) {
  assert(window >= 1 && percentile > 0.0 && percentile <= 100.0);
  if (names_.empty()) names_.emplace_back();
  runs_.resize(names_.size());
  invalidated_.resize(names_.size());
  recent_count_.resize(names_.size());
}

void Estimator::add(RunTime run, std::size_t mode, std::size_t items) {
  assert(run.cpu.count() >= 0 && run.wait.count() >= 0);
  if (mode >= names_.size()) mode = 0;
  push(runs_[mode], Seen{run, items}, window_ * kSampledWindows);
  if (invalidated_[mode] > 0 && --invalidated_[mode] == 0) forget_before(mode, kMinSamples);

  const std::size_t capacity = window_ * kFrequencyWindows;
  const bool full = recent_modes_.values.size() == capacity;
  const std::size_t replaced = push(recent_modes_, mode, capacity);
  if (full) --recent_count_[replaced];
  ++recent_count_[mode];
  ++count_;
}

std::vector<Estimator::Seen> Estimator::newest(std::size_t mode, std::size_t max_count) const {
  const Ring<Seen>& runs = runs_[mode];
  const std::size_t size = runs.values.size();
  std::vector<Seen> newest;
  for (std::size_t i = size - std::min(max_count, size); i < size; ++i) {
    newest.push_back(runs.values[(runs.oldest + i) % size]);
  }
  return newest;
}

std::vector<RunTime> Estimator::newest_runs(std::size_t mode, std::size_t max_count) const {
  std::vector<RunTime> runs;
  for (const Seen& seen : newest(mode, max_count)) runs.push_back(without_items(seen));
  return runs;
}

RunTime Estimator::without_items(const Seen& seen) const {
  const Nanos items = to_nanos(per_item_ * static_cast<double>(seen.items));
  return {std::max(seen.run.cpu - items, Nanos{0}), seen.run.wait};
}

std::optional<Estimator::Shift> Estimator::forget_before(std::size_t mode, std::size_t runs) {
  assert(runs >= 1);
  if (mode >= names_.size()) mode = 0;
  const std::size_t known = runs_[mode].values.size();
  if (runs >= std::min(known, window_)) {
    runs_[mode] = {newest(mode, runs), 0};
    return std::nullopt;
  }
  const std::vector<RunTime> window = newest_runs(mode, window_);
  const Shift shift{percentile_of(std::span(window).first(window.size() - runs), percentile_),
                    percentile_of(std::span(window).last(runs), percentile_)};
  runs_[mode] = {newest(mode, runs), 0};
  return shift;
}

void Estimator::rescale(double factor) {
  for (std::size_t mode = 0; mode < runs_.size(); ++mode) rescale(factor, mode);
}

void Estimator::rescale(double factor, std::size_t mode) {
  assert(factor > 0.0);
  for (auto& [run, items] : runs_[mode].values) {
    run.cpu = Nanos{std::llround(static_cast<double>(run.cpu.count()) * factor)};
  }
}

void Estimator::invalidate() { invalidated_.assign(invalidated_.size(), kMinSamples); }

std::vector<RunTime> Estimator::sample() const {
  constexpr double kSize = 200.0;
  std::vector<RunTime> sample;
  const auto total = static_cast<double>(recent_modes_.values.size());
  for (std::size_t mode = 0; mode < runs_.size(); ++mode) {
    std::vector<RunTime> runs = newest_runs(mode, runs_[mode].values.size());
    if (runs.empty() || recent_count_[mode] == 0) continue;
    std::sort(runs.begin(), runs.end());
    const double frequency = static_cast<double>(recent_count_[mode]) / total;
    const auto size = static_cast<std::size_t>(std::ceil(kSize * frequency));
    for (std::size_t i = 0; i < size; ++i) sample.push_back(runs[(2 * i + 1) * runs.size() / (2 * size)]);
  }
  return sample;
}

Millis Estimator::wait(double percentile) const {
  std::vector<RunTime> runs;
  for (std::size_t mode = 0; mode < runs_.size(); ++mode) {
    // As many of each mode as it is frequent among a window of runs.
    if (recent_modes_.values.empty()) break;
    const double frequency =
        static_cast<double>(recent_count_[mode]) / static_cast<double>(recent_modes_.values.size());
    const auto share = static_cast<std::size_t>(std::ceil(frequency * static_cast<double>(window_)));
    const std::vector<RunTime> newest = newest_runs(mode, share);
    runs.insert(runs.end(), newest.begin(), newest.end());
  }
  return percentile_of(runs, percentile, &RunTime::wait);
}

CostProfile Estimator::profile(double percentile) const {
  assert(count_ > 0);
  const auto total = static_cast<double>(recent_modes_.values.size());
  std::vector<ModeCost> modes;
  modes.reserve(names_.size());
  for (std::size_t mode = 0; mode < names_.size(); ++mode) {
    const Millis cost = percentile_of(newest_runs(mode, window_), percentile);
    modes.push_back({names_[mode], static_cast<double>(recent_count_[mode]) / total, cost});
  }
  return CostProfile::of_modes(std::move(modes)).with_per_item(per_item_);
}

}  // namespace ctn::model
