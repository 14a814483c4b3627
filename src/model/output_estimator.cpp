#include "model/output_estimator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace ctn::model {
namespace {

constexpr double kMoved = 0.1;
constexpr double kStandardErrors = 4.0;

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double standard_error(std::span<const double> values, double mean) {
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares) / static_cast<double>(values.size());
}

}  // namespace

void OutputEstimator::add(bool emitted) {
  ++since_;
  if (!emitted) return;
  const std::uint64_t gap = std::exchange(since_, 0);
  // How long the first one would have been is not known.
  if (!std::exchange(started_, true)) return;
  if (gap == 1 && gaps_.empty()) {
    even_ = std::min(even_ + 1, kWindow);
    return;
  }
  for (; even_ > 0; --even_) add_gap(1);
  add_gap(gap);
}

void OutputEstimator::add_gap(std::uint64_t runs) {
  if (gaps_.size() < kWindow) {
    gaps_.push_back(static_cast<double>(runs));
  } else {
    gaps_[oldest_] = static_cast<double>(runs);
    oldest_ = (oldest_ + 1) % kWindow;
  }
  const std::optional<std::size_t> since_change =
      detector_.add(std::chrono::milliseconds{static_cast<std::int64_t>(runs)});
  if (since_change) {
    std::rotate(gaps_.begin(), gaps_.begin() + static_cast<std::ptrdiff_t>(oldest_), gaps_.end());
    gaps_.erase(gaps_.begin(), gaps_.end() - static_cast<std::ptrdiff_t>(std::min(*since_change, gaps_.size())));
    oldest_ = 0;
    told_from_ = 0;
  }
  tell();
}

void OutputEstimator::tell() {
  if (gaps_.size() < kMinGaps) return;
  const double mean = mean_of(gaps_);
  const double moved = std::abs(mean - told_);
  const bool known_better = gaps_.size() >= 2 * told_from_;
  if (known_better) told_from_ = gaps_.size();
  if (moved <= kMoved * told_) return;
  if (known_better || moved > kStandardErrors * standard_error(gaps_, mean)) told_ = mean;
}

}  // namespace ctn::model
