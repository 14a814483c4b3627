#include "base/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace ctn {

double percentile_of_sorted(std::span<const double> sorted, double percent) {
  assert(!sorted.empty() && percent > 0.0 && percent <= 100.0);
  const auto count = static_cast<double>(sorted.size());
  // The small term keeps 95 % of 20 at rank 19 where the product is 19.000000000000004.
  const double rank = std::ceil(percent / 100.0 * count - 1e-9);
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  return sorted[std::min(index, sorted.size() - 1)];
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

}  // namespace ctn
