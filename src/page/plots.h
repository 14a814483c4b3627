// Pictures of a run as SVG, which need no script: these are printed, and shown if scripts are off. Colours that are not
// arguments come from the page's style (style.css).
//
// Units: milliseconds, unless something else is said. Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "page/story.h"

namespace ctn::page {

struct Curve {
  std::string label;
  std::string colour;
  std::vector<double> samples_ms;  // in any order
  bool dashed = false;
};

struct PlotLevel {
  std::string label;  // also the class of the line: "bound", "promised", "expected"
  double value_ms = 0.0;
};

// Samples over their rank: towards the right, half, a tenth, a hundredth of all samples are larger. Empty if no curve
// has samples.
std::string percentile_picture(const std::string& title, const std::vector<Curve>& curves,
                               const std::vector<PlotLevel>& levels);

// Which lanes used each core over the whole run, as areas stacked on each other, with a mark for each plan that came
// into force.
std::string cores_picture(const Story& story, const std::vector<std::string>& colours);

// The response times of a chain over the whole run: mean, 95th percentile and maximum.
std::string responses_picture(const Story& story, std::size_t chain);

}  // namespace ctn::page
