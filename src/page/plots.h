// Pictures of a run that need no script, as SVG: they are what is printed, and what is there where scripts are off.
// Colours other than those given follow the page's style (style.css).
//
// Units: milliseconds where nothing else is said. Thread safety: pure functions.
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

// How large samples are by their rank: to the right half, a tenth, a hundredth ... of all are larger. Empty where no
// curve has samples.
std::string percentile_picture(const std::string& title, const std::vector<Curve>& curves,
                               const std::vector<PlotLevel>& levels);

// Who used each core over the whole run, one area a lane upon the other; marks where plans came into force.
std::string cores_picture(const Story& story, const std::vector<std::string>& colours);

// The response times of a chain over the whole run: mean, 95th percentile and maximum.
std::string responses_picture(const Story& story, std::size_t chain);

}  // namespace ctn::page
