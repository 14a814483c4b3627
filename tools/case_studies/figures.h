// Figures that several studies have.
//
// Thread safety: pure functions.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "comparison.h"
#include "report/plot.h"
#include "study.h"

namespace ctn::case_studies {

// For each batch a point: of how many runs in a hundred something is so, with its 95 % interval; or the metric's mean,
// with that of the mean.
report::Figure by_batch(const Study& study, const Runs& runs, const std::string& metric);

// For each of these batches a line: of a list over time, the median of the runs.
struct Timeline {
  std::vector<std::string> batches;
  std::string list;
  double stretch = 1.0;  // seconds
  std::string title;
  std::string unit;  // of the y axis
};
report::Figure over_time(const Study& study, const Runs& runs, const Timeline& timeline);

// A scheduler has the same colour everywhere. `name`: a batch's, of which the last part counts.
report::Colour colour_of(const std::string& name);

}  // namespace ctn::case_studies
