// Charts as self-contained SVG: lines and points over an x axis, with error bars or bands, marker lines and bounds.
//
//   report::Panel panel{.title = "Response time", .x = {.label = "Source rate (Hz)"}, .y = {.label = "ms"}};
//   panel.series.push_back({.label = "measured", .points = {{30, 52.1, 48, 60}, {60, 31.0, 29, 35}}});
//   panel.markers.push_back({.x = 47, .label = "Catan: 47 Hz"});
//   auto svg = report::render_svg({.title = "Face tracking", .panels = {panel}});
//
// How: a script is made (plot_script.h) and run by gnuplot, a program of its own (Debian package gnuplot-nox). Legends
// and marker labels stand above the plot area, never on the data. Colours can be told apart by the colour-blind; series
// differ in the shape of their points too.
//
// Units: pixels for sizes; the axes' are the caller's. Thread safety: pure values and functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"

namespace ctn::report {

enum class Colour { kBlue, kOrange, kGreen, kPurple, kYellow, kSky, kInk, kGrey };

// A point that is not finite (or beyond 1e30), or not positive on a logarithmic axis, is left out, and the line is
// broken there.
struct Point {
  double x = 0.0;
  double y = 0.0;
  std::optional<double> low{};  // the ends of the spread: both or none
  std::optional<double> high{};
};

enum class Line { kSolid, kDashed, kNone };
enum class Spread { kBars, kBand };

struct Series {
  std::string label{};  // empty: not in the legend
  std::vector<Point> points{};
  Line line = Line::kSolid;
  bool marks = true;  // a mark at each point
  Spread spread = Spread::kBars;
  std::optional<Colour> colour{};  // none: the next of the palette
};

// A vertical line, labelled at the top: a chosen rate, a change of plan.
struct Marker {
  double x = 0.0;
  std::string label{};
  Colour colour = Colour::kInk;
  bool dashed = false;
};

// A horizontal line, labelled at its right end: a bound, a goal.
struct Level {
  double y = 0.0;
  std::string label{};
  Colour colour = Colour::kGrey;
};

// A place on an axis with a text of its own.
struct Tick {
  double at = 0.0;
  std::string label{};
};

// With `ticks`, an x axis has these in place of numbers; labels that have no room side by side are slanted.
// Without `min` and `max` (finite; positive on a logarithmic axis) the axis covers all points, spreads and lines; a
// linear y axis then begins at 0 unless something lies below.
struct Axis {
  std::string label{};
  bool log = false;
  std::optional<double> min{};
  std::optional<double> max{};
  std::vector<Tick> ticks{};
};

struct Panel {
  std::string title{};
  Axis x{};
  Axis y{};
  std::vector<Series> series{};
  std::vector<Marker> markers{};
  std::vector<Level> levels{};
};

enum class Arrangement { kStacked, kSideBySide };

struct Figure {
  std::string title{};  // what the figure shows, for those who cannot see it and for tooltips
  std::vector<Panel> panels{};
  Arrangement arrangement = Arrangement::kStacked;
  int width = 760;  // of the whole figure
  int panel_height = 330;
};

// kInline: for an HTML page (html.h), transparent, in the page's own text colour, so that it suits light and dark.
// kStandalone: for a file of its own, on white.
enum class SvgUse { kInline, kStandalone };

// An <svg> element (kStandalone: with the XML declaration). Errors: kEnvironment where gnuplot is missing or fails.
// Precondition: at least one panel, sizes positive.
Result<std::string> render_svg(const Figure& figure, SvgUse use = SvgUse::kInline);

}  // namespace ctn::report
