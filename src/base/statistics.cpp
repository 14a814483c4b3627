#include "base/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace ctn {
namespace {

// Where the percentile is among so many samples, once they are sorted.
std::size_t index_of_percentile(std::size_t samples, double percent) {
  // The small term keeps 95 % of 20 at rank 19 where the product is 19.000000000000004.
  const double rank = std::ceil(percent / 100.0 * static_cast<double>(samples) - 1e-9);
  return std::min(static_cast<std::size_t>(std::max(rank, 1.0)), samples) - 1;
}

}  // namespace

double percentile_of_sorted(std::span<const double> sorted, double percent) {
  assert(!sorted.empty() && percent > 0.0 && percent <= 100.0);
  return sorted[index_of_percentile(sorted.size(), percent)];
}

double median_of(std::vector<double> samples) {
  assert(!samples.empty());
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(samples.begin(), middle, samples.end());
  return *middle;
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
  auto from = samples.begin();  // those before it are no larger than all from it on
  const auto next = [&](double percent) {
    const auto at = samples.begin() + static_cast<std::ptrdiff_t>(index_of_percentile(samples.size(), percent));
    std::nth_element(from, at, samples.end());
    from = at;
    return *at;
  };
  summary.p50 = next(50.0);
  summary.p95 = next(95.0);
  summary.p99 = next(99.0);
  summary.max = *std::max_element(from, samples.end());
  return summary;
}

}  // namespace ctn
