#include "top_chain_screen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

#include "base/text.h"
#include "top_figures.h"
#include "top_sections.h"
#include "top_table.h"

namespace ctn::tool {
namespace {

ScreenSection summaries(const view::Chain& chain, const ScreenState& state, std::size_t width) {
  ScreenTable table({{"MEASURED ms", 0}, {"mean", 0}, {"p50", 0}, {"p95", 0}, {"p99", 0}, {"max", 0}, {"samples", 0}});
  const auto add = [&](const char* name, const Summary& summary) {
    table.add({{name},
               {short_figure(summary, &Summary::mean)},
               {short_figure(summary, &Summary::p50)},
               {short_figure(summary, &Summary::p95)},
               {short_figure(summary, &Summary::p99)},
               {short_figure(summary, &Summary::max)},
               {std::to_string(summary.count), Style::kDim}});
  };
  add("response time", chain.response_ms);
  add("latency", chain.latency_ms);
  add("period", chain.period_ms);
  return {table.lines(width, state.unicode), 4, 0};
}

// In at most so many lines; intervals are merged to fit.
ScreenSection distribution_section(const view::Distribution& distribution, std::size_t rows, std::size_t width,
                                   bool unicode) {
  ScreenSection section{{{{"RESPONSE TIMES, how many took how long", Style::kHeading}}}, 0, 0};
  const std::vector<std::uint64_t>& counts = distribution.counts;
  if (counts.empty()) {
    section.lines.push_back({{"  no response in this time", Style::kDim}});
    return section;
  }
  std::size_t together = 1;
  while (together < counts.size() && (counts.size() % together != 0 || counts.size() / together > rows)) ++together;
  if (distribution.width_ms <= 0.0) together = counts.size();  // all samples are equal
  std::vector<std::uint64_t> sums;
  for (std::size_t at = 0; at < counts.size(); at += together) {
    const auto first = counts.begin() + static_cast<std::ptrdiff_t>(at);
    sums.push_back(std::accumulate(first, first + static_cast<std::ptrdiff_t>(together), std::uint64_t{0}));
  }
  const std::uint64_t max = *std::max_element(sums.begin(), sums.end());
  for (std::size_t index = 0; index < sums.size(); ++index) {
    const double from = distribution.from_ms + distribution.width_ms * static_cast<double>(index * together);
    const double part = max > 0 ? static_cast<double>(sums[index]) / static_cast<double>(max) : 0.0;
    section.lines.push_back(
        {{fmt::format("{:>9} ms ", short_figure(from)), Style::kPlain},
         {bar_text(part, width > 40 ? std::min<std::size_t>(width - 30, 100) : 10, unicode), Style::kGood},
         {fmt::format(" {}", sums[index]), sums[index] == 0 ? Style::kDim : Style::kPlain}});
  }
  return section;
}

}  // namespace

void chain_screen(const view::Picture& picture, const ScreenState& state, ScreenSize size,
                  std::vector<ScreenLine>& lines) {
  const std::size_t end = size.rows - 1;
  const view::Chain& chain = picture.chains[std::min(state.selected, picture.chains.size() - 1)];
  lines.push_back({{shortened(printable(chain.path), size.columns, state.unicode), Style::kTitle}});
  lines.push_back({{"response now ", Style::kPlain},
                   {short_figure(chain.newest_ms), response_style(chain, chain.newest_ms.value_or(0.0))},
                   {fmt::format(" ms, expected {}, promised {}, bound {}", short_figure(chain.expected_ms),
                                short_figure(chain.promised_ms), short_figure(chain.bound_ms)),
                    Style::kPlain}});
  lines.push_back(
      {{fmt::format("late: {} over the bound, {} over what was promised", chain.over_bound, chain.over_promise),
        Style::kPlain}});
  if (!chain.late_by.empty()) {
    lines.push_back({{"why late: ", Style::kPlain}, {causes_text(chain.late_by), Style::kWarning}});
  }
  const std::size_t drawn = size.columns >= 80 ? 60 : 30;
  lines.push_back({{"worst, 60 s   ", Style::kPlain}, {sparkline(chain.worst_ms, drawn, state.unicode), Style::kGood}});
  std::vector<const view::Node*> nodes;
  for (const std::string& name : chain.nodes) {
    for (const view::Node& node : picture.nodes) {
      if (node.name == name) nodes.push_back(&node);
    }
  }
  std::vector<ScreenSection> sections{summaries(chain, state, size.columns),
                                      node_section(nodes, picture, state, size.columns)};
  sections[1].min = sections[1].lines.size();
  if (!state.causes.empty()) {
    ScreenSection causes{{}, 0, 0};
    for (const std::string& line : state.causes) {
      causes.lines.push_back({{line, causes.lines.empty() ? Style::kHeading : Style::kPlain}});
    }
    causes.min = causes.lines.size();
    sections.push_back(std::move(causes));
  }
  std::size_t taken = lines.size();
  for (const ScreenSection& section : sections) taken += section.lines.size();
  const std::size_t left = end > taken + 1 ? end - taken - 1 : 1;
  sections.push_back(distribution_section(chain.distribution, left, size.columns, state.unicode));
  place_sections(std::move(sections), end > lines.size() ? end - lines.size() : 0, state.unicode, lines);
}

}  // namespace ctn::tool
