#include "top_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "top_figures.h"
#include "top_table.h"

namespace ctn::tool {
namespace {

// Shortens a section to so many lines; the last one says how many rows are missing.
std::vector<ScreenLine> fitted(ScreenSection section, std::size_t lines, bool unicode) {
  std::vector<ScreenLine>& all = section.lines;
  if (all.size() <= lines) return std::move(all);
  if (lines == 0) return {};
  const std::size_t shown = lines >= 3 ? lines - 2 : 0;  // rows, without headings and the hint
  const std::size_t rows = all.size() - 1;
  const std::size_t first = section.selected < shown ? 0 : std::min(section.selected + 1 - shown, rows - shown);
  const auto row = all.begin() + 1 + static_cast<std::ptrdiff_t>(first);
  std::vector<ScreenLine> result{all.front()};
  result.insert(result.end(), row, row + static_cast<std::ptrdiff_t>(shown));
  if (lines >= 2) {
    result.push_back(
        {{fmt::format("  {} {} more: they do not fit", unicode ? "…" : "...", rows - shown), Style::kDim}});
  }
  return result;
}

}  // namespace

void place_sections(std::vector<ScreenSection> sections, std::size_t rows, bool unicode,
                    std::vector<ScreenLine>& lines) {
  std::vector<std::size_t> given;
  std::size_t left = rows;
  for (const ScreenSection& section : sections) {
    given.push_back(std::min({section.lines.size(), section.min, left}));
    left -= given.back();
  }
  for (std::size_t index = 0; index < sections.size(); ++index) {
    const std::size_t more = std::min(sections[index].lines.size() - given[index], left);
    // A section of headings and a hint alone would say nothing.
    if (given[index] == 0 && more < std::min<std::size_t>(sections[index].lines.size(), 3)) continue;
    given[index] += more;
    left -= more;
  }
  const auto used = static_cast<std::size_t>(
      std::count_if(given.begin(), given.end(), [](std::size_t number) { return number > 0; }));
  const bool spaced = left >= used;
  for (std::size_t index = 0; index < sections.size(); ++index) {
    if (given[index] == 0) continue;
    if (spaced) lines.emplace_back();
    for (ScreenLine& line : fitted(std::move(sections[index]), given[index], unicode)) lines.push_back(std::move(line));
  }
}

ScreenSection node_section(const std::vector<const view::Node*>& nodes, const view::Picture& picture,
                           const ScreenState& state, std::size_t width) {
  ScreenTable table({{"NODE", 0},
                     {"subchain", 4},
                     {"Hz", 0},
                     {"planned", 1},
                     {"compute ms", 0},
                     {"p95", 0},
                     {"max", 2},
                     {"period ms", 1},
                     {"p95", 2},
                     {"wait ms", 3},
                     {"CPU", 1},
                     {"runs", 5}});
  for (const view::Node* node : nodes) {
    table.add({{printable(node->name)},
               {node->subchain ? printable(picture.subchains[*node->subchain].name) : "-", Style::kDim},
               {short_figure(node->rate_hz)},
               {short_figure(node->expected_hz), Style::kDim},
               {short_figure(node->compute_ms, &Summary::mean)},
               {short_figure(node->compute_ms, &Summary::p95)},
               {short_figure(node->compute_ms, &Summary::max)},
               {short_figure(node->period_ms, &Summary::mean)},
               {short_figure(node->period_ms, &Summary::p95)},
               {short_figure(node->wait_ms, &Summary::mean)},
               {percent_text(node->cores)},
               {std::to_string(node->runs), Style::kDim}});
  }
  return {table.lines(width, state.unicode), 0, 0};
}

Style response_style(const view::Chain& chain, double response_ms) {
  if (chain.bound_ms && response_ms > *chain.bound_ms) return Style::kBad;
  if (chain.promised_ms && response_ms > *chain.promised_ms) return Style::kWarning;
  return Style::kPlain;
}

std::string causes_text(const std::vector<view::LateBy>& causes) {
  std::string text;
  for (const view::LateBy& late : causes) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", printable(late.cause), late.count);
  }
  return text;
}

}  // namespace ctn::tool
