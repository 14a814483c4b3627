#include "base/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "base/quick_summary.h"

namespace ctn {
namespace {

// Where it is among so many in ascending order.
std::size_t rank_of(double percent, std::size_t samples) {
  const auto count = static_cast<double>(samples);
  // The small term keeps 95 % of 20 at rank 19 where the product is 19.000000000000004.
  const double rank = std::ceil(percent / 100.0 * count - 1e-9);
  return std::min(static_cast<std::size_t>(std::max(rank, 1.0)) - 1, samples - 1);
}

}  // namespace

double percentile_of_sorted(std::span<const double> sorted, double percent) {
  assert(!sorted.empty() && percent > 0.0 && percent <= 100.0);
  return sorted[rank_of(percent, sorted.size())];
}

Summary summarize(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
  return {.count = samples.size(),
          .mean = sum / static_cast<double>(samples.size()),
          .p50 = percentile_of_sorted(samples, 50.0),
          .p95 = percentile_of_sorted(samples, 95.0),
          .p99 = percentile_of_sorted(samples, 99.0),
          .max = samples.back()};
}

Summary summarize_quickly(std::vector<double> samples) {
  if (samples.empty()) return {};
  Summary summary{.count = samples.size()};
  summary.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
  // From the highest rank down, each among those that are no larger than the one before.
  auto end = samples.end();
  const auto take = [&](double percent) {
    const auto place = samples.begin() + static_cast<std::ptrdiff_t>(rank_of(percent, samples.size()));
    if (place < end) {
      std::nth_element(samples.begin(), place, end);
      end = place;
    }
    return *place;
  };
  summary.max = take(100.0);
  summary.p99 = take(99.0);
  summary.p95 = take(95.0);
  summary.p50 = take(50.0);
  return summary;
}

}  // namespace ctn
