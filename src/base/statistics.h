// Summaries of samples: the same definition of a percentile wherever Catan states one.
//
// A percentile is by nearest rank: the smallest sample such that at least p percent of all samples are no larger. It is
// always a sample that occurred. Units: those of the samples. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "catan/summary.h"  // IWYU pragma: export

namespace ctn {

// Precondition: `sorted` ascending and not empty, 0 < percent <= 100.
double percentile_of_sorted(std::span<const double> sorted, double percent);

// The one in the middle once they are sorted; of an even number the higher of the two. Precondition: not empty.
double median_of(std::vector<double> samples);

Summary summarize(std::vector<double> samples);
// The same but for the last digits of the mean, in a fraction of the time where there are thousands of samples: for
// who looks often.
Summary summarize_quickly(std::vector<double> samples);

}  // namespace ctn
