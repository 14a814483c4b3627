#include "page/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "page/buckets.h"
#include "report/escape.h"

namespace ctn::page {
namespace {

constexpr double kLeft = 52.0;  // room for the labels of the axis

std::string svg_of(double width, double height, const std::string& title, const std::string& content) {
  return fmt::format(
      "<svg class=\"plot\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" aria-label=\"{2}\">\n{3}</svg>\n", width,
      height, report::escaped(title), content);
}

// Steps of 1, 2 or 5 times a power of ten, about `count` of them up to `max`.
double step_of(double max, int count) {
  const double rough = max / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10.0 * power;
}

std::string axis_text(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format("<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>", x, y, anchor, text);
}

std::string grid_line(double x0, double y0, double x1, double y1) {
  return fmt::format("<line class=\"grid\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", x0, y0, x1, y1);
}

// Horizontal lines with their values, from 0 to `max`.
std::string scale(double max, double left, double right, double top, double bottom, const char* unit) {
  std::string text;
  const double step = step_of(max, 4);
  for (double value = 0.0; value <= max * 1.0001; value += step) {
    const double y = bottom - value / max * (bottom - top);
    text += grid_line(left, y, right, y) + axis_text(left - 6, y + 4, "end", fmt::format("{:g}{}", value, unit));
  }
  return text;
}

std::string seconds_scale(Micros duration, double left, double right, double bottom) {
  std::string text;
  const double seconds = static_cast<double>(duration) / 1e6;
  const double step = step_of(seconds, 8);
  for (double value = 0.0; value <= seconds * 1.0001; value += step) {
    text += axis_text(left + value / seconds * (right - left), bottom + 16, "middle", fmt::format("{:g} s", value));
  }
  return text;
}

}  // namespace

std::string percentile_picture(const std::string& title, const std::vector<Curve>& curves,
                               const std::vector<PlotLevel>& levels) {
  constexpr double kWidth = 430.0, kTop = 12.0, kBottom = 190.0, kRight = kWidth - 12.0;
  double max = 0.0;
  std::size_t longest = 0;
  for (const Curve& curve : curves) {
    for (const double sample : curve.samples_ms) max = std::max(max, sample);
    longest = std::max(longest, curve.samples_ms.size());
  }
  if (longest == 0) return {};
  const double largest = max;
  for (const PlotLevel& level : levels) {
    if (level.value_ms < 2.5 * largest) max = std::max(max, level.value_ms);
  }
  max = max > 0.0 ? 1.06 * max : 1.0;
  const double decades = std::max(1.0, std::log10(static_cast<double>(longest)));
  const auto x = [&](double rest) { return kLeft - std::log10(rest) / decades * (kRight - kLeft); };
  const auto y = [&](double value) { return kBottom - value / max * (kBottom - kTop); };
  std::string text = scale(max, kLeft, kRight, kTop, kBottom, "");
  for (int decade = 0; decade <= static_cast<int>(decades); ++decade) {
    const double at = x(std::pow(10.0, -decade));
    text += grid_line(at, kTop, at, kBottom);
    const std::string label =
        decade == 0 ? "all" : fmt::format("{:.{}f} %", 100.0 - std::pow(10.0, 2 - decade), std::max(0, decade - 2));
    text += axis_text(at, kBottom + 16, "middle", label);
  }
  for (const PlotLevel& level : levels) {
    if (level.value_ms > max) continue;
    text += fmt::format("<line class=\"level {}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>",
                        level.label, kLeft, y(level.value_ms), kRight, y(level.value_ms));
    // Lines are often close together, so their names stand at different ends and sides.
    const bool bound = level.label == "bound";
    const double beside = level.label == "expected" ? 13.0 : -4.0;
    text += axis_text(bound ? kRight - 4 : kLeft + 4, y(level.value_ms) + beside, bound ? "end" : "start", level.label);
  }
  for (const Curve& curve : curves) {
    std::vector<double> sorted = curve.samples_ms;
    if (sorted.empty()) continue;
    std::sort(sorted.begin(), sorted.end());
    const auto count = static_cast<double>(sorted.size());
    std::string path;
    double last = -10.0;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      const double at = x((count - static_cast<double>(i)) / count);
      if (at - last < 1.0 && i + 1 < sorted.size()) continue;
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", at, y(sorted[i]));
      last = at;
    }
    text += fmt::format("<path class=\"curve{}\" style=\"stroke:{}\" d=\"{}\"/>", curve.dashed ? " dashed" : "",
                        curve.colour, path);
  }
  return svg_of(kWidth, kBottom + 24, title, text);
}

std::string cores_picture(const Story& story, const std::vector<std::string>& colours) {
  constexpr std::size_t kBuckets = 256;
  constexpr double kWidth = 1100.0, kHeight = 56.0, kRight = kWidth - 8.0;
  const auto shares = busy_shares(story, kBuckets);
  const std::size_t cores = std::min<std::size_t>(std::max<std::size_t>(story.cores, 1), 32);
  const auto x = [&](double bucket) { return kLeft + bucket / static_cast<double>(kBuckets) * (kRight - kLeft); };
  std::string text;
  for (std::size_t core = 0; core < cores; ++core) {
    const double bottom = 8.0 + static_cast<double>(core + 1) * (kHeight + 10.0) - 10.0;
    text += fmt::format("<rect class=\"track\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>", kLeft,
                        bottom - kHeight, kRight - kLeft, kHeight);
    text +=
        axis_text(kLeft - 6, bottom - kHeight / 2 + 4, "end", story.cores > 0 ? fmt::format("core {}", core) : "all");
    std::vector<double> level(kBuckets, 0.0);
    for (std::size_t lane = 0; lane < story.lanes.size(); ++lane) {
      const auto here = [&](std::size_t bucket) {
        if (shares[lane][bucket] == 0) return false;
        const auto middle = static_cast<Micros>((static_cast<double>(bucket) + 0.5) / static_cast<double>(kBuckets) *
                                                static_cast<double>(story.duration));
        const PlanSpan* const plan = plan_at(story, middle);
        return story.cores == 0 || (plan != nullptr && std::any_of(plan->placements.begin(), plan->placements.end(),
                                                                   [&](const Placement& one) {
                                                                     return one.lane == lane && one.core == core;
                                                                   }));
      };
      std::vector<double> upper = level;
      for (std::size_t i = 0; i < kBuckets; ++i) {
        if (here(i)) upper[i] = std::min(1.0, level[i] + shares[lane][i] / 255.0);
      }
      if (upper == level) continue;
      std::string outline;
      const auto corner = [&](std::size_t edge, double share) {
        outline += fmt::format("{}{:.1f} {:.1f}", outline.empty() ? "M" : "L", x(static_cast<double>(edge)),
                               bottom - kHeight * share);
      };
      for (std::size_t i = 0; i < kBuckets; ++i) {
        corner(i, upper[i]);
        corner(i + 1, upper[i]);
      }
      for (std::size_t i = kBuckets; i-- > 0;) {
        corner(i + 1, level[i]);
        corner(i, level[i]);
      }
      level = std::move(upper);
      text += fmt::format("<path fill=\"{}\" d=\"{}z\"><title>{}</title></path>", colours[lane], outline,
                          report::escaped(story.lanes[lane].name));
    }
  }
  const double bottom = 8.0 + static_cast<double>(cores) * (kHeight + 10.0) - 10.0;
  std::size_t marks = 0;
  for (const PlanSpan& plan : story.plans) {
    if (++marks > 200) break;
    const double at = kLeft + static_cast<double>(plan.at) / static_cast<double>(story.duration) * (kRight - kLeft);
    text += fmt::format("<line class=\"mark\" x1=\"{0:.1f}\" y1=\"2\" x2=\"{0:.1f}\" y2=\"{1:.1f}\"/>", at, bottom);
  }
  text += seconds_scale(story.duration, kLeft, kRight, bottom);
  return svg_of(kWidth, bottom + 24, "Which subchains used each core over the whole run", text);
}

std::string responses_picture(const Story& story, std::size_t chain) {
  constexpr double kWidth = 700.0, kTop = 10.0, kBottom = 190.0, kRight = kWidth - 10.0;
  constexpr std::size_t kBuckets = 160;
  std::vector<Sample> samples;
  for (const ResponsePoint& response : story.responses[chain]) samples.push_back({response.end, response.response_ms});
  const std::vector<Band> buckets = bands(samples, story.duration, kBuckets);
  if (buckets.empty()) return {};
  double max = 0.0;
  for (const Band& band : buckets) max = std::max(max, band.max);
  max = max > 0.0 ? 1.06 * max : 1.0;
  const auto path = [&](double Band::*value, const char* kind) {
    std::string line;
    for (const Band& band : buckets) {
      const double x =
          kLeft + (static_cast<double>(band.bucket) + 0.5) / static_cast<double>(kBuckets) * (kRight - kLeft);
      line +=
          fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x, kBottom - band.*value / max * (kBottom - kTop));
    }
    return fmt::format("<path class=\"curve {}\" d=\"{}\"/>", kind, line);
  };
  std::string text =
      scale(max, kLeft, kRight, kTop, kBottom, "") + seconds_scale(story.duration, kLeft, kRight, kBottom);
  text += path(&Band::max, "max") + path(&Band::p95, "p95") + path(&Band::mean, "mean");
  const std::optional<double> bound = story.figures.chains[chain].bound_ms;
  if (bound && *bound < max) {
    const double y = kBottom - *bound / max * (kBottom - kTop);
    text += fmt::format("<line class=\"level bound\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", kLeft,
                        y, kRight, y);
  }
  return svg_of(kWidth, kBottom + 24, "Response times of " + story.figures.chains[chain].path + " over time", text);
}

}  // namespace ctn::page
