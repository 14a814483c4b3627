#include "report/plot_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include "report/escape.h"

namespace ctn::report {
namespace {

// Pixels.
constexpr double kFont = 13.0;
constexpr double kTitleFont = 15.0;
constexpr double kCharacter = 0.56 * kFont;  // mean width of one
constexpr double kRow = 20.0;                // of the legend or of marker labels
constexpr double kLeft = 66.0;
constexpr double kRight = 22.0;
constexpr double kBottom = 60.0;
constexpr double kSlant = 25.0;   // of ticks' labels, in degrees
constexpr double kSlope = 0.42;   // its sine
constexpr double kSample = 24.0;  // a legend's piece of line
constexpr double kGap = 20.0;     // between entries of a legend

constexpr std::array kPalette{Colour::kBlue,   Colour::kOrange, Colour::kGreen,
                              Colour::kPurple, Colour::kYellow, Colour::kSky};
constexpr std::array kShapes{7, 5, 9, 13, 11};  // gnuplot's filled circle, square, triangles, diamond

const char* rgb(Colour colour) {
  switch (colour) {
    case Colour::kBlue:
      return "#0072b2";
    case Colour::kOrange:
      return "#d55e00";
    case Colour::kGreen:
      return "#009e73";
    case Colour::kPurple:
      return "#b6609a";
    case Colour::kYellow:
      return "#d99a00";
    case Colour::kSky:
      return "#4aa8de";
    case Colour::kGrey:
      return "#7d858d";
    case Colour::kInk:
      break;
  }
  return kInkColour;
}

// As a string of gnuplot's that nothing is expanded in; one line. An apostrophe cannot be written in one that begins
// with it, so it becomes the typographic one.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : cleaned(text)) {
    if (c == '\'') {
      result += "\u2019";
    } else {
      result += c;
    }
  }
  return result + "'";
}

double text_width(const std::string& text) {
  const auto characters = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; });
  return static_cast<double>(characters) * kCharacter;
}

// Beyond it, arithmetic on ranges overflows.
constexpr double kLargest = 1e30;

struct Range {
  double low = 0.0;
  double high = 1.0;
  bool log = false;

  bool holds(double value) const { return std::abs(value) <= kLargest && (!log || value >= 1.0 / kLargest); }
  double fraction(double value) const {
    if (log) return (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
    return (value - low) / (high - low);
  }
};

Range range_of(const Axis& axis, const std::vector<double>& values, bool from_zero) {
  Range range{.log = axis.log};
  std::vector<double> usable;
  std::copy_if(values.begin(), values.end(), std::back_inserter(usable), [&](double v) { return range.holds(v); });
  if (usable.empty()) usable = {1.0, 10.0};
  const auto [min, max] = std::minmax_element(usable.begin(), usable.end());
  double low = *min;
  double high = *max;
  if (axis.log) {
    const double room = high > low ? std::pow(high / low, 0.06) : 1.5;
    low /= room;
    high *= room;
  } else {
    const double room = high > low ? 0.05 * (high - low) : std::max(1.0, 0.1 * std::abs(high));
    high += room;
    low = from_zero && low >= 0.0 ? 0.0 : low - room;
  }
  range.low = axis.min && range.holds(*axis.min) ? *axis.min : low;
  range.high = axis.max && range.holds(*axis.max) ? *axis.max : high;
  if (!(range.high > range.low)) range.high = range.low + (axis.log ? range.low : 1.0 + std::abs(range.low));
  return range;
}

struct Box {  // of the plot area, in pixels from the figure's top left
  double left = 0.0;
  double top = 0.0;
  double width = 0.0;
  double height = 0.0;
};

struct Style {
  const char* colour;
  int shape;
};

class PanelScript {
 public:
  PanelScript(const Figure& figure, std::size_t index, Box cell, double figure_height)
      : figure_(figure), panel_(figure.panels[index]), index_(index), cell_(cell), figure_height_(figure_height) {
    measure();
  }

  std::string write() {
    area_ = {cell_.left + kLeft, cell_.top, cell_.width - kLeft - kRight, 0.0};
    write_data();
    double top = cell_.top + 8.0;
    if (!panel_.title.empty()) {
      label(panel_.title, screen(cell_.left + kLeft, top + 10.0), "left",
            fmt::format(" font '{}:Bold,{}' tc rgb '{}'", kFontName, kTitleFont, kInkColour));
      top += 28.0;
    }
    top = write_legend(top);
    const int rows = place_marker_labels();
    area_.top = top + kRow * rows + 6.0;
    area_.height = std::max(20.0, cell_.top + cell_.height - kBottom - slanted_height() - area_.top);
    write_axes();
    write_markers();
    write_levels();
    write_plot();
    return script_;
  }

 private:
  void measure() {
    std::vector<double> xs;
    std::vector<double> ys;
    for (const Series& series : panel_.series) {
      for (const Point& point : series.points) {
        xs.push_back(point.x);
        ys.push_back(point.y);
        if (point.low && point.high) ys.insert(ys.end(), {*point.low, *point.high});
      }
    }
    for (const Marker& marker : panel_.markers) xs.push_back(marker.x);
    for (const Tick& tick : panel_.x.ticks) xs.push_back(tick.at);
    for (const Level& level : panel_.levels) ys.push_back(level.y);
    x_ = range_of(panel_.x, xs, false);
    y_ = range_of(panel_.y, ys, true);
  }

  double widest_tick() const {
    double widest = 0.0;
    for (const Tick& tick : panel_.x.ticks) widest = std::max(widest, text_width(tick.label));
    return widest;
  }
  // How much room ticks' labels take below what level ones do.
  double slanted_height() const {
    const double room = area_.width / std::max(1.0, static_cast<double>(panel_.x.ticks.size()));
    return widest_tick() + kGap / 2.0 <= room ? 0.0 : kSlope * widest_tick();
  }

  std::string block(std::size_t series) const { return fmt::format("$p{}s{}", index_, series); }
  std::string screen(double x, double y) const {
    return fmt::format("screen {:.5f},{:.5f}", x / figure_.width, 1.0 - y / figure_height_);
  }
  void label(const std::string& text, const std::string& at, const char* align, const std::string& more = {}) {
    script_ += fmt::format("set label {} at {} {} front{}\n", quoted(text), at, align,
                           more.empty() ? fmt::format(" tc rgb '{}'", kInkColour) : more);
  }
  Style style(std::size_t index) const {
    std::size_t taken = 0;  // series with a colour of their own take none of the palette
    for (std::size_t i = 0; i < index; ++i) taken += panel_.series[i].colour ? 0 : 1;
    const Colour colour = panel_.series[index].colour.value_or(kPalette[taken % kPalette.size()]);
    return {rgb(colour), kShapes[index % kShapes.size()]};
  }
  static const char* dash(Line line) { return line == Line::kDashed ? "dashtype (5,4)" : "dashtype solid"; }

  void write_data() {
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      script_ += block(i) + " << EOD\n";
      for (const Point& point : panel_.series[i].points) {
        if (!x_.holds(point.x) || !y_.holds(point.y)) {
          script_ += "\n";
          continue;
        }
        const bool spread = point.low && point.high && y_.holds(*point.low) && y_.holds(*point.high);
        script_ += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", point.x, point.y, spread ? *point.low : point.y,
                               spread ? *point.high : point.y);
      }
      script_ += "EOD\n";
    }
    script_ += "unset label\nunset arrow\n";
  }

  // Entries side by side, in as many rows as they need. Returns where it ends.
  double write_legend(double top) {
    double x = area_.left;
    double y = top;
    bool any = false;
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      if (series.label.empty()) continue;
      const double width = kSample + 8.0 + text_width(series.label);
      if (any && x + width > area_.left + area_.width) {
        x = area_.left;
        y += kRow;
      }
      any = true;
      write_legend_entry(i, x, y + 0.5 * kRow);
      x += width + kGap;
    }
    return any ? y + kRow : top;
  }

  void write_legend_entry(std::size_t index, double x, double y) {
    const Series& series = panel_.series[index];
    const Style look = style(index);
    if (series.line != Line::kNone) {
      script_ += fmt::format("set arrow from {} to {} nohead lw 2 lc rgb '{}' {} front\n", screen(x, y),
                             screen(x + kSample, y), look.colour, dash(series.line));
    }
    if (series.marks) {
      script_ += fmt::format("set label '' at {} tc rgb '{}' point pt {} ps 0.75 lc rgb '{}' front\n",
                             screen(x + 0.5 * kSample, y), kInkColour, look.shape, look.colour);
    }
    label(series.label, screen(x + kSample + 8.0, y), "left");
  }

  // Puts each label above its line, in the lowest row where it touches no other. Returns the number of rows.
  int place_marker_labels() {
    std::vector<double> row_ends;  // how far right each row is taken
    std::vector<std::size_t> order(panel_.markers.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [this](std::size_t a, std::size_t b) { return panel_.markers[a].x < panel_.markers[b].x; });
    label_x_.assign(order.size(), 0.0);
    label_row_.assign(order.size(), 0);
    for (const std::size_t i : order) {
      const Marker& marker = panel_.markers[i];
      if (!x_.holds(marker.x) || marker.label.empty()) continue;
      const double half = 0.5 * text_width(marker.label);
      const double line = area_.left + area_.width * x_.fraction(marker.x);
      const double min = cell_.left + half + 4.0;
      const double max = std::max(min, cell_.left + cell_.width - half - 4.0);
      label_x_[i] = std::clamp(line, min, max);
      std::size_t row = 0;
      while (row < row_ends.size() && row_ends[row] > label_x_[i] - half) ++row;
      if (row == row_ends.size()) row_ends.push_back(0.0);
      row_ends[row] = label_x_[i] + half + 10.0;
      label_row_[i] = static_cast<int>(row);
    }
    return static_cast<int>(row_ends.size());
  }

  void write_markers() {
    for (std::size_t i = 0; i < panel_.markers.size(); ++i) {
      const Marker& marker = panel_.markers[i];
      if (!x_.holds(marker.x) || marker.x < x_.low || marker.x > x_.high) continue;
      const double x = area_.left + area_.width * x_.fraction(marker.x);
      const double label_y = area_.top - 10.0 - kRow * label_row_[i];
      const double line_top = marker.label.empty() ? area_.top : label_y + 9.0;
      script_ += fmt::format("set arrow from {} to {} nohead lw 1.6 lc rgb '{}' {} back\n", screen(x, line_top),
                             screen(x, area_.top + area_.height), rgb(marker.colour),
                             dash(marker.dashed ? Line::kDashed : Line::kSolid));
      if (!marker.label.empty()) {
        label(marker.label, screen(label_x_[i], label_y), "center", fmt::format(" tc rgb '{}'", rgb(marker.colour)));
      }
    }
  }

  void write_levels() {
    for (const Level& level : panel_.levels) {
      if (!y_.holds(level.y) || level.y < y_.low || level.y > y_.high) continue;
      const double y = area_.top + area_.height * (1.0 - y_.fraction(level.y));
      script_ += fmt::format("set arrow from {} to {} nohead lw 1.4 lc rgb '{}' dashtype (3,4) back\n",
                             screen(area_.left, y), screen(area_.left + area_.width, y), rgb(level.colour));
      label(level.label, screen(area_.left + area_.width - 4.0, y - 9.0), "right",
            fmt::format(" tc rgb '{}'", rgb(level.colour)));
    }
  }

  void write_axes() {
    script_ += fmt::format("set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\n", area_.left / figure_.width,
                           (area_.left + area_.width) / figure_.width);
    script_ += fmt::format("set tmargin at screen {:.5f}\nset bmargin at screen {:.5f}\n",
                           1.0 - area_.top / figure_height_, 1.0 - (area_.top + area_.height) / figure_height_);
    label(panel_.x.label, screen(area_.left + 0.5 * area_.width, area_.top + area_.height + slanted_height() + 44.0),
          "center");
    label(panel_.y.label, screen(cell_.left + 14.0, area_.top + 0.5 * area_.height), "center",
          fmt::format(" rotate by 90 tc rgb '{}'", kInkColour));
    write_axis('x', x_);
    write_axis('y', y_);
  }

  void write_axis(char name, const Range& range) {
    script_ += fmt::format("{}set logscale {}\nset {}range [{:.9g}:{:.9g}]\n", range.log ? "" : "un", name, name,
                           range.low, range.high);
    script_ += fmt::format("set {}tics norotate autofreq\n", name);
    if (name == 'x' && !panel_.x.ticks.empty()) {
      write_ticks();
    } else if (range.log) {
      script_ += fmt::format("set {}tics ({})\n", name, log_tics(range));
    }
  }

  void write_ticks() {
    std::string list;
    for (const Tick& tick : panel_.x.ticks) {
      list += fmt::format("{}{} {:.9g}", list.empty() ? "" : ", ", quoted(tick.label), tick.at);
    }
    const std::string slant = slanted_height() > 0.0 ? fmt::format("rotate by {} right ", kSlant) : "";
    script_ += fmt::format("set xtics {}({})\n", slant, list);
  }

  // gnuplot labels whole decades only, of which a range of rates may hold one or none. Where even 1, 2 and 5 of each
  // decade are too few, the range is so narrow that equal steps do.
  static std::string log_tics(const Range& range) {
    std::vector<double> tics;
    for (double decade = std::floor(std::log10(range.low)); decade <= std::log10(range.high); decade += 1.0) {
      for (const double step : {1.0, 2.0, 5.0}) {
        const double value = step * std::pow(10.0, decade);
        if (step > 1.0 && range.high / range.low > 1e3) continue;
        if (value >= range.low && value <= range.high) tics.push_back(value);
      }
    }
    if (tics.size() < 3) tics = even_tics(range);
    return fmt::format("{:.6g}", fmt::join(tics, ", "));
  }

  // Three to eight multiples of a round number.
  static std::vector<double> even_tics(const Range& range) {
    const double quarter = (range.high - range.low) / 4.0;
    const double decade = std::pow(10.0, std::floor(std::log10(quarter)));
    const double step = (quarter >= 5.0 * decade ? 5.0 : quarter >= 2.0 * decade ? 2.0 : 1.0) * decade;
    std::vector<double> tics;
    for (double count = std::ceil(range.low / step); count * step <= range.high; count += 1.0) {
      tics.push_back(count * step);
    }
    return tics;
  }

  // Bands first, then bars, then lines: what matters most is on top.
  void write_plot() {
    std::vector<std::string> layers[3];
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      if (std::none_of(series.points.begin(), series.points.end(),
                       [this](const Point& point) { return x_.holds(point.x) && y_.holds(point.y); })) {
        continue;
      }
      const Style look = style(i);
      const bool spread = std::any_of(series.points.begin(), series.points.end(),
                                      [](const Point& point) { return point.low && point.high; });
      if (spread && series.spread == Spread::kBand) {
        layers[0].push_back(fmt::format(
            "{} using 1:3:4 with filledcurves fc rgb '{}' fs transparent solid 0.18 noborder", block(i), look.colour));
      } else if (spread) {
        layers[1].push_back(
            fmt::format("{} using 1:2:3:4 with yerrorbars lw 1.3 pt 0 ps 0 lc rgb '{}'", block(i), look.colour));
      }
      if (series.line != Line::kNone) {
        layers[2].push_back(
            fmt::format("{} using 1:2 with lines lw 2 lc rgb '{}' {}", block(i), look.colour, dash(series.line)));
      }
      if (series.marks) {
        layers[2].push_back(
            fmt::format("{} using 1:2 with points pt {} ps 0.75 lc rgb '{}'", block(i), look.shape, look.colour));
      }
    }
    std::string parts;
    for (const auto& layer : layers) {
      for (const std::string& part : layer) parts += (parts.empty() ? "" : ", \\\n  ") + part;
    }
    script_ += "plot " + (parts.empty() ? "NaN" : parts) + "\n";
  }

  const Figure& figure_;
  const Panel& panel_;
  std::size_t index_;
  Box cell_;
  double figure_height_;
  Range x_;
  Range y_;
  Box area_;
  std::vector<double> label_x_;  // by marker
  std::vector<int> label_row_;
  std::string script_;
};

}  // namespace

std::string plot_script(const Figure& figure) {
  const auto count = static_cast<double>(figure.panels.size());
  const bool stacked = figure.arrangement == Arrangement::kStacked;
  const double width = stacked ? figure.width : figure.width / count;
  const double height = figure.panel_height;
  const double figure_height = stacked ? height * count : height;
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg size {},{} fixed noenhanced font '{},{}' rounded\n"
      "unset key\nset border 1 lc rgb '{}' lw 1.2\nset tics out nomirror scale 0.6,0.3 tc rgb '{}'\n"
      "set ytics scale 0\nset format '%g'\nset grid ytics lt 1 lc rgb '{}' lw 1 dashtype solid\n"
      "set errorbars 0.8\nset pointintervalbox 0\nset multiplot\n",
      figure.width, figure_height, kFontName, kFont, kInkColour, kInkColour, kGridColour);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const double offset = static_cast<double>(i);
    const Box cell{stacked ? 0.0 : width * offset, stacked ? height * offset : 0.0, width, height};
    script += PanelScript(figure, i, cell, figure_height).write();
  }
  return script + "unset multiplot\n";
}

}  // namespace ctn::report
