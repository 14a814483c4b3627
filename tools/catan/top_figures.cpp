#include "top_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ctn::tool {

std::string short_figure(double value) {
  if (value < 10.0) return fmt::format("{:.2f}", value);
  if (value < 1000.0) return fmt::format("{:.1f}", value);
  return fmt::format("{:.0f}", value);
}
std::string short_figure(const std::optional<double>& value) { return value ? short_figure(*value) : "-"; }
std::string short_figure(const Summary& summary, double Summary::*which) {
  return summary.count > 0 ? short_figure(summary.*which) : "-";
}
std::string percent_text(double part) { return fmt::format("{:.0f} %", 100.0 * part); }

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::max(seconds, 0.0));
  if (whole < 60) return fmt::format("{:.1f} s", std::max(seconds, 0.0));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

Span count_text(std::uint64_t number, Style style) {
  return {std::to_string(number), number == 0 ? Style::kDim : style};
}

std::string sparkline(const std::vector<std::optional<double>>& values, std::size_t width, bool unicode) {
  static constexpr const char* kBlocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  static constexpr const char* kAscii[] = {"_", ".", "-", "~", "=", "+", "*", "#"};
  double largest = 0.0;
  for (const std::optional<double>& value : values) largest = std::max(largest, value.value_or(0.0));
  const std::size_t step = std::max<std::size_t>(1, values.size() / std::max<std::size_t>(width, 1));
  std::string text;
  for (std::size_t at = values.size() % step; at + step <= values.size(); at += step) {
    std::optional<double> worst;
    for (std::size_t index = at; index < at + step; ++index) worst = std::max(worst, values[index]);
    if (!worst) {
      text += ' ';
      continue;
    }
    const double part = largest > 0.0 ? *worst / largest : 0.0;
    const std::size_t level = std::min<std::size_t>(static_cast<std::size_t>(part * 8.0), 7);
    text += unicode ? kBlocks[level] : kAscii[level];
  }
  return text;
}

std::string bar_text(double part, std::size_t width, bool unicode) {
  const auto full = static_cast<std::size_t>(std::lround(std::clamp(part, 0.0, 1.0) * static_cast<double>(width)));
  std::string text;
  for (std::size_t at = 0; at < full; ++at) text += unicode ? "█" : "#";
  return text + std::string(width - full, unicode ? ' ' : '.');
}

}  // namespace ctn::tool
