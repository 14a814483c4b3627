// Summaries of samples: the same definition of a percentile wherever Catan states one.
//
// A percentile is by nearest rank: the smallest sample such that at least p percent of all samples are no larger. It is
// always a sample that occurred. Units: those of the samples. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace ctn {

// Precondition: `sorted` ascending and not empty, 0 < percent <= 100.
double percentile_of_sorted(std::span<const double> sorted, double percent);

struct SampleSummary {
  std::size_t count = 0;  // 0: all else is 0 too
  double mean = 0.0;
  double p50 = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

SampleSummary summarize(std::vector<double> samples);

}  // namespace ctn
