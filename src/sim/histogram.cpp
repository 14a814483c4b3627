#include "sim/histogram.h"

#include <algorithm>
#include <cmath>

namespace ctn::sim {
namespace {

double ms(double nanos) { return nanos / 1e6; }

}  // namespace

void Histogram::add(Nanos duration) {
  const auto value = static_cast<std::uint64_t>(std::max<Nanos::rep>(duration.count(), 0));
  const auto width = static_cast<unsigned>(std::bit_width(value));
  const unsigned octave = width > kBits ? width - kBits : 0;
  // The leading bit is always 1: the kBits below it tell the steps of an octave apart.
  const std::uint64_t step = octave == 0 ? value : (value >> (octave - 1)) & (kSteps - 1);
  if (!octaves_[octave]) octaves_[octave] = std::make_unique<Octave>();
  ++(*octaves_[octave])[step];
  ++count_;
  sum_ += value;
  max_ = std::max(max_, value);
}

double Histogram::percentile_ms(double percent) const {
  const double rank = std::max(1.0, std::ceil(percent / 100.0 * static_cast<double>(count_) - 1e-9));
  std::uint64_t below = 0;
  for (std::size_t octave = 0; octave < octaves_.size(); ++octave) {
    if (!octaves_[octave]) continue;
    for (std::size_t step = 0; step < kSteps; ++step) {
      below += (*octaves_[octave])[step];
      if (static_cast<double>(below) < rank) continue;
      if (octave == 0) return ms(static_cast<double>(step));
      const double unit = std::ldexp(1.0, static_cast<int>(octave) - 1);
      const double middle = (static_cast<double>(kSteps + step) + 0.5) * unit - 0.5;
      return ms(std::min(middle, static_cast<double>(max_)));
    }
  }
  return ms(static_cast<double>(max_));
}

Summary Histogram::summary_ms() const {
  if (count_ == 0) return {};
  return {.count = static_cast<std::size_t>(count_),
          .mean = ms(static_cast<double>(sum_) / static_cast<double>(count_)),
          .p50 = percentile_ms(50.0),
          .p95 = percentile_ms(95.0),
          .p99 = percentile_ms(99.0),
          .max = ms(static_cast<double>(max_))};
}

}  // namespace ctn::sim
