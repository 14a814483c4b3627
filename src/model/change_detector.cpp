#include "model/change_detector.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ctn::model {
namespace {

constexpr double kAllowance = 0.2;
constexpr double kMaxThresholdFactor = 4.0;
constexpr double kBackWithin = 200.0;  // runs: what the limit is raised by is then a third

constexpr double kMinRatio = 1.1;
constexpr Nanos::rep kMinDifference = 20'000;

}  // namespace

void ChangeDetector::Sum::add(double score) {
  value += score - kAllowance;
  ++runs;
  if (value <= 0.0) *this = {};
}

double ChangeDetector::score(Nanos cpu) const {
  const Nanos::rep cost = cpu.count();
  const auto min_above =
      std::max(static_cast<Nanos::rep>(static_cast<double>(cost) * kMinRatio), cost + kMinDifference);
  const auto max_below =
      std::min(static_cast<Nanos::rep>(static_cast<double>(cost) / kMinRatio), cost - kMinDifference);
  const auto below = std::lower_bound(ranked_.begin(), ranked_.end(), max_below) - ranked_.begin();
  const auto above = ranked_.end() - std::upper_bound(ranked_.begin(), ranked_.end(), min_above);
  return 0.5 * static_cast<double>(below - above) / static_cast<double>(ranked_.size());
}

void ChangeDetector::trust_all_but(std::size_t newest) {
  const std::size_t count = suspects_.size() - std::min({newest, suspects_.size(), kReference});
  for (std::size_t index = 0; index < count; ++index) {
    if (reference_.size() < kReference) {
      reference_.push_back(suspects_[index]);
      ranked_.insert(std::upper_bound(ranked_.begin(), ranked_.end(), suspects_[index]), suspects_[index]);
    } else {
      exchange(reference_[oldest_], suspects_[index]);
      reference_[oldest_] = suspects_[index];
      oldest_ = (oldest_ + 1) % kReference;
    }
  }
  suspects_.erase(suspects_.begin(), suspects_.begin() + static_cast<std::ptrdiff_t>(count));
}

// In the ranks, one of those that are `before` for one that is `after`.
void ChangeDetector::exchange(Nanos::rep before, Nanos::rep after) {
  const auto left = std::lower_bound(ranked_.begin(), ranked_.end(), before);
  if (after > before) {
    const auto right = std::lower_bound(left, ranked_.end(), after);
    *std::move(left + 1, right, left) = after;
  } else {
    const auto right = std::upper_bound(ranked_.begin(), left, after);
    std::move_backward(right, left, left + 1);
    *right = after;
  }
}

void ChangeDetector::begin_with_newest(std::size_t runs) {
  reference_.assign(suspects_.end() - static_cast<std::ptrdiff_t>(std::min(runs, suspects_.size())), suspects_.end());
  ranked_ = reference_;
  std::sort(ranked_.begin(), ranked_.end());
  suspects_.clear();
  oldest_ = 0;
  up_ = {};
  down_ = {};
}

std::optional<std::size_t> ChangeDetector::add(Nanos cpu) {
  assert(cpu.count() >= 0);
  const double scored = reference_.size() < kMinReference ? 0.0 : score(cpu);
  suspects_.push_back(cpu.count());
  up_.add(scored);
  down_.add(-scored);
  threshold_ -= (threshold_ - kThreshold) / kBackWithin;
  const bool up = up_.value >= threshold_;
  if (!up && down_.value < threshold_) {
    trust_all_but(std::max(up_.runs, down_.runs));
    return std::nullopt;
  }
  const std::size_t runs = up ? up_.runs : down_.runs;
  threshold_ = std::min(2.0 * threshold_, kMaxThresholdFactor * kThreshold);
  begin_with_newest(runs);
  return runs;
}

void ChangeDetector::rescale(double factor) {
  assert(factor > 0.0);
  for (std::vector<Nanos::rep>* runs : {&reference_, &ranked_, &suspects_}) {
    for (Nanos::rep& cost : *runs) cost = std::llround(static_cast<double>(cost) * factor);
  }
}

}  // namespace ctn::model
