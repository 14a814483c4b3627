#include "top_screen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "base/text.h"
#include "os/cpu_set.h"
#include "top_table.h"

namespace ctn::tool {
namespace {

using view::Picture;

std::string figure(double value) {
  if (value < 10.0) return fmt::format("{:.2f}", value);
  if (value < 1000.0) return fmt::format("{:.1f}", value);
  return fmt::format("{:.0f}", value);
}
std::string figure(const std::optional<double>& value) { return value ? figure(*value) : "-"; }
std::string figure(const Summary& summary, double Summary::*which) {
  return summary.count > 0 ? figure(summary.*which) : "-";
}
std::string whole_percent(double part) { return fmt::format("{:.0f} %", 100.0 * part); }

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::max(seconds, 0.0));
  if (whole < 60) return fmt::format("{:.1f} s", std::max(seconds, 0.0));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

Span count(std::uint64_t number, Style style = Style::kWarning) {
  return {std::to_string(number), number == 0 ? Style::kDim : style};
}

// --- Drawings of figures ---

// One character for each step, the newest on the right; scaled from 0 to the largest value.
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

std::string bar(double part, std::size_t width, bool unicode) {
  const auto full = static_cast<std::size_t>(std::lround(std::clamp(part, 0.0, 1.0) * static_cast<double>(width)));
  std::string text;
  for (std::size_t at = 0; at < full; ++at) text += unicode ? "█" : "#";
  return text + std::string(width - full, unicode ? ' ' : '.');
}

// --- The top of the screen ---

ScreenLine title(const Picture& picture, const ScreenState& state) {
  ScreenLine line{{printable(picture.app), Style::kTitle},
                  {fmt::format("  {}, {}, CPUs {}, up {}", printable(picture.scheduler),
                               picture.real_time ? "real-time levels" : "rates only",
                               os::to_string(os::CpuSet(picture.cpus)), duration_text(picture.up_s)),
                   Style::kPlain}};
  if (state.paused) line.push_back({"  PAUSED: p goes on", Style::kWarning});
  return line;
}

ScreenLine state_line(const Picture& picture) {
  switch (picture.state) {
    case view::State::kRunning:
      break;
    case view::State::kStalled:
      return {{fmt::format("no sign of life for {}: figures are as of then", duration_text(picture.silent_ms / 1000.0)),
               Style::kBad}};
    case view::State::kKilled:
      return {{"its process was killed, or has crashed: figures are of its last seconds", Style::kBad}};
    case view::State::kEnded:
      return {{"the run has ended: figures are of its last seconds", Style::kWarning}};
  }
  std::string text = fmt::format("objective {}", figure(picture.objective));
  if (picture.plan) {
    text += fmt::format(", planned {}; plan {} old ({}), {} made", figure(picture.plan->objective),
                        duration_text(picture.up_s - picture.plan->at_s), printable(picture.plan->reason),
                        picture.plans_made);
  } else {
    text += "; no plan in force";
  }
  ScreenLine line{{std::move(text), Style::kPlain}};
  if (picture.starved > 0) {
    line.push_back({fmt::format("; starved {}x, {} ms", picture.starved, figure(picture.starved_ms)), Style::kWarning});
  }
  return line;
}

std::string bound_text(const view::RelaxedBound& bound) {
  if (bound.bound.ends_with(".min_rate")) {
    return fmt::format("{} {} Hz, not {} Hz", printable(bound.bound), figure(1000.0 / bound.planned_ms),
                       figure(1000.0 / bound.asked_ms));
  }
  return fmt::format("{} {} ms, not {} ms", printable(bound.bound), figure(bound.planned_ms), figure(bound.asked_ms));
}

std::vector<ScreenLine> top_lines(const Picture& picture, const ScreenState& state) {
  std::vector<ScreenLine> lines{title(picture, state), state_line(picture)};
  if (picture.plan && !picture.plan->relaxed.empty()) {
    std::string text = fmt::format("bounds relaxed by {:.3g}: ", picture.plan->relax_factor);
    for (std::size_t index = 0; index < picture.plan->relaxed.size(); ++index) {
      text += (index == 0 ? "" : ", ") + bound_text(picture.plan->relaxed[index]);
    }
    lines.push_back({{std::move(text), Style::kWarning}});
  }
  if (picture.plan && !picture.plan->assumed.empty()) {
    std::string text = "have not run, so that their costs are assumed: ";
    for (std::size_t index = 0; index < picture.plan->assumed.size(); ++index) {
      text += (index == 0 ? "" : ", ") + printable(picture.plan->assumed[index].node);
    }
    lines.push_back({{std::move(text), Style::kWarning}});
  }
  return lines;
}

// --- Sections ---

// Sections stand one below the other. Each begins with a line of headings.
struct Section {
  std::vector<ScreenLine> lines;
  std::size_t min = 0;       // lines that it gets before any section gets more
  std::size_t selected = 0;  // row that must be visible
};

// The style of one of the chain's response times.
Style style_of(const view::Chain& chain, double response_ms) {
  if (chain.bound_ms && response_ms > *chain.bound_ms) return Style::kBad;
  if (chain.promised_ms && response_ms > *chain.promised_ms) return Style::kWarning;
  return Style::kPlain;
}

Section chain_section(const Picture& picture, const ScreenState& state, std::size_t width) {
  ScreenTable table({{"RESPONSE ms", 0},
                     {"now", 0},
                     {"mean", 6},
                     {"expected", 5},
                     {"p95", 0},
                     {"max", 4},
                     {"promised", 1},
                     {"bound", 2},
                     {"late", 1},
                     {"of", 8},
                     {"p50", 10},
                     {"p99", 9},
                     {"weight", 7},
                     {"worst, 60 s", 3}});
  const std::size_t drawn = width >= 150 ? 60 : width >= 110 ? 30 : 20;
  for (std::size_t index = 0; index < picture.chains.size(); ++index) {
    const view::Chain& chain = picture.chains[index];
    const Summary& response = chain.response_ms;
    table.add({{printable(width < 110 ? fmt::format("{}", fmt::join(chain.nodes, ">")) : chain.path)},
               {figure(chain.newest_ms), style_of(chain, chain.newest_ms.value_or(0.0))},
               {figure(response, &Summary::mean)},
               {figure(chain.expected_ms), Style::kDim},
               {figure(response, &Summary::p95), style_of(chain, response.p95)},
               {figure(response, &Summary::max)},
               {figure(chain.promised_ms), Style::kDim},
               {figure(chain.bound_ms), Style::kDim},
               chain.bound_ms ? count(chain.over_bound, Style::kBad) : count(chain.over_promise),
               {std::to_string(response.count), Style::kDim},
               {figure(response, &Summary::p50)},
               {figure(response, &Summary::p99)},
               {fmt::format("{:.3g}", chain.weight), Style::kDim},
               {sparkline(chain.worst_ms, drawn, state.unicode), Style::kGood}},
              index == state.selected);
  }
  return {table.lines(width, state.unicode), 5, state.selected};
}

// "pre-empted 12, long-run 3"
std::string causes_text(const std::vector<view::LateBy>& causes) {
  std::string text;
  for (const view::LateBy& late : causes) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", printable(late.cause), late.count);
  }
  return text;
}

// Adds nothing where no response was late.
Section cause_section(const Picture& picture, const ScreenState& state, std::size_t width) {
  Section section;
  for (const view::Chain& chain : picture.chains) {
    if (chain.late_by.empty()) continue;
    if (section.lines.empty()) section.lines.push_back({{"WHY LATE, by cause", Style::kHeading}});
    const std::string name = printable(fmt::format("{}", fmt::join(chain.nodes, ">")));
    section.lines.push_back(
        cut_off({{shortened(name, std::max<std::size_t>(width / 3, 1), state.unicode) + "  ", Style::kPlain},
                 {causes_text(chain.late_by), chain.bound_ms ? Style::kBad : Style::kWarning}},
                width));
  }
  section.min = std::min<std::size_t>(section.lines.size(), 3);
  return section;
}

const char* sort_text(SortBy sort) {
  switch (sort) {
    case SortBy::kApp:
      return "";
    case SortBy::kWeight:
      return " by weight";
    case SortBy::kCpu:
      return " by CPU";
    case SortBy::kLate:
      return " by late";
    case SortBy::kPeriod:
      return " by period";
  }
  return "";
}

double cpu_of(const Picture& picture, std::size_t subchain) {
  double sum = 0.0;
  for (const view::Node& node : picture.nodes) sum += node.subchain == subchain ? node.cores : 0.0;
  return sum;
}

std::vector<std::size_t> sorted_subchains(const Picture& picture, const ScreenState& state) {
  std::vector<std::size_t> order(picture.subchains.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t index) {
    const view::Subchain& subchain = picture.subchains[index];
    switch (state.sort) {
      case SortBy::kApp:
        return -static_cast<double>(index);
      case SortBy::kWeight:
        return subchain.weight;
      case SortBy::kCpu:
        return cpu_of(picture, index);
      case SortBy::kLate:
        return static_cast<double>(subchain.late);
      case SortBy::kPeriod:
        return subchain.period_ms.mean;
    }
    return 0.0;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return state.reversed ? key(a) < key(b) : key(a) > key(b); });
  return order;
}

// "p3": a fixed priority; "1/4", "x1.5": the share of its slot; "own": it owns its cores.
std::string place_text(const view::Subchain& subchain) {
  if (subchain.priority) return fmt::format("p{}", *subchain.priority);
  if (subchain.sharing == view::Sharing::kOwned) return "own";
  if (!subchain.share || *subchain.share <= 0.0) return "-";
  const double every = 1.0 / *subchain.share;
  if (std::abs(every - std::round(every)) < 1e-6) return fmt::format("1/{:.0f}", every);
  return fmt::format("x{:.3g}", *subchain.share);
}

// How long a subchain may be silent: ten periods, but at least a second.
bool is_silent(const view::Subchain& subchain) {
  const double usual = std::max(subchain.expected_period_ms.value_or(0.0), subchain.period_ms.mean);
  return !subchain.silent_ms || *subchain.silent_ms > std::max(10.0 * usual, 1000.0);
}

std::string cores_text(const view::Subchain& subchain) {
  return subchain.cores.empty() ? "-" : os::to_string(os::CpuSet(subchain.cores));
}

Section subchain_section(const Picture& picture, const ScreenState& state, std::size_t width) {
  ScreenTable table({{std::string("SUBCHAIN") + sort_text(state.sort) + (state.reversed ? " (reversed)" : ""), 0},
                     {"core", 1},
                     {"prio", 1},
                     {"period ms", 0},
                     {"planned", 1},
                     {"used p95", 2},
                     {"budget", 2},
                     {"late", 1},
                     {"stolen", 3},
                     {"CPU", 3},
                     {"runs", 7},
                     {"over", 4},
                     {"took p95", 6},
                     {"promised", 6},
                     {"trigger late", 8},
                     {"stole", 5},
                     {"weight", 9}});
  for (const std::size_t index : sorted_subchains(picture, state)) {
    const view::Subchain& subchain = picture.subchains[index];
    const bool over = subchain.budget_ms && subchain.used_ms.count > 0 && subchain.used_ms.p95 > *subchain.budget_ms;
    std::vector<Span> cells{{printable(subchain.name)},
                            {cores_text(subchain)},
                            {place_text(subchain)},
                            {figure(subchain.period_ms, &Summary::mean)},
                            {figure(subchain.expected_period_ms), Style::kDim},
                            {figure(subchain.used_ms, &Summary::p95), over ? Style::kWarning : Style::kPlain},
                            {figure(subchain.budget_ms), Style::kDim},
                            count(subchain.late),
                            count(subchain.stolen),
                            {whole_percent(cpu_of(picture, index))},
                            {std::to_string(subchain.runs), Style::kDim},
                            count(subchain.overruns),
                            {figure(subchain.execution_ms, &Summary::p95)},
                            {figure(subchain.promised_execution_ms), Style::kDim},
                            {figure(subchain.trigger_late_ms, &Summary::p95)},
                            count(subchain.stole, Style::kPlain),
                            {fmt::format("{:.3g}", subchain.weight), Style::kDim}};
    if (picture.state == view::State::kRunning && is_silent(subchain)) {
      cells[3] = {subchain.silent_ms ? "silent " + duration_text(*subchain.silent_ms / 1000.0) : "no run", Style::kBad};
    }
    table.add(std::move(cells));
  }
  return {table.lines(width, state.unicode), 6, 0};
}

Section core_section(const Picture& picture, const ScreenState& state, std::size_t width) {
  Section section{{{{"CORE   shared by    busy", Style::kHeading}}}, 4, 0};
  for (const view::Core& core : picture.cores) {
    const std::string cpu = core.cpu ? fmt::format("CPU {}", *core.cpu) : "CPU ?";
    std::string sharing = core.sharing == view::Sharing::kNone ? "-" : to_string(core.sharing);
    if (core.frame_ms) sharing = fmt::format("frames {}", figure(*core.frame_ms));
    ScreenLine line{{fmt::format("{:<6} {:<12} ", cpu, sharing), Style::kPlain},
                    {bar(core.busy, width >= 110 ? 20 : 10, state.unicode), Style::kGood},
                    {fmt::format(" {:>5} ", whole_percent(core.busy)), Style::kPlain}};
    for (const view::CoreUse& use : core.uses) {
      std::string text = fmt::format(" {} {}", printable(use.name), whole_percent(use.cores));
      if (use.slots && width >= 110) text += fmt::format(" (slots {})", whole_percent(*use.slots));
      line.push_back({std::move(text), use.planned ? Style::kPlain : Style::kDim});
    }
    section.lines.push_back(cut_off(std::move(line), width));
  }
  return section;
}

Section node_section(const std::vector<const view::Node*>& nodes, const Picture& picture, const ScreenState& state,
                     std::size_t width) {
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
               {figure(node->rate_hz)},
               {figure(node->expected_hz), Style::kDim},
               {figure(node->compute_ms, &Summary::mean)},
               {figure(node->compute_ms, &Summary::p95)},
               {figure(node->compute_ms, &Summary::max)},
               {figure(node->period_ms, &Summary::mean)},
               {figure(node->period_ms, &Summary::p95)},
               {figure(node->wait_ms, &Summary::mean)},
               {whole_percent(node->cores)},
               {std::to_string(node->runs), Style::kDim}});
  }
  return {table.lines(width, state.unicode), 0, 0};
}

Style style_of(const view::Event& event) {
  if (event.kind == "plan" || event.kind == "cost-change" || event.kind == "changed") return Style::kPlain;
  const bool bad = event.kind == "watchdog" || event.kind == "node-left" || event.kind == "replan-failed" ||
                   event.kind == "lost-reports" || event.kind == "starved";
  return bad ? Style::kBad : Style::kWarning;
}

Section event_section(const Picture& picture, std::size_t width) {
  Section section{{{{"NOTICE, the newest first", Style::kHeading}}}, 4, 0};
  if (picture.lost > 0) {
    section.lines.push_back({{fmt::format("events were lost {} times, and figures began anew: catan top was kept from "
                                          "reading them",
                                          picture.lost),
                              Style::kWarning}});
  }
  for (auto event = picture.events.rbegin(); event != picture.events.rend(); ++event) {
    section.lines.push_back(
        cut_off({{fmt::format("{:>9}  ", duration_text(event->at_s)), Style::kDim},
                 {fmt::format("{}: {}", printable(event->kind), printable(event->detail)), style_of(*event)}},
                width));
  }
  return section;
}

// --- How sections share the screen ---

// Shortens a section to so many lines; the last one says how many rows are missing.
std::vector<ScreenLine> fitted(Section section, std::size_t lines, bool unicode) {
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

void place(std::vector<Section> sections, std::size_t rows, bool unicode, std::vector<ScreenLine>& lines) {
  std::vector<std::size_t> given;
  std::size_t left = rows;
  for (const Section& section : sections) {
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

// --- One chain ---

Section summaries(const view::Chain& chain, const ScreenState& state, std::size_t width) {
  ScreenTable table({{"MEASURED ms", 0}, {"mean", 0}, {"p50", 0}, {"p95", 0}, {"p99", 0}, {"max", 0}, {"samples", 0}});
  const auto add = [&](const char* name, const Summary& summary) {
    table.add({{name},
               {figure(summary, &Summary::mean)},
               {figure(summary, &Summary::p50)},
               {figure(summary, &Summary::p95)},
               {figure(summary, &Summary::p99)},
               {figure(summary, &Summary::max)},
               {std::to_string(summary.count), Style::kDim}});
  };
  add("response time", chain.response_ms);
  add("latency", chain.latency_ms);
  add("period", chain.period_ms);
  return {table.lines(width, state.unicode), 4, 0};
}

// In at most so many lines; intervals are merged to fit.
Section distribution_section(const view::Distribution& distribution, std::size_t rows, std::size_t width,
                             bool unicode) {
  Section section{{{{"RESPONSE TIMES, how many took how long", Style::kHeading}}}, 0, 0};
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
        {{fmt::format("{:>9} ms ", figure(from)), Style::kPlain},
         {bar(part, width > 40 ? std::min<std::size_t>(width - 30, 100) : 10, unicode), Style::kGood},
         {fmt::format(" {}", sums[index]), sums[index] == 0 ? Style::kDim : Style::kPlain}});
  }
  return section;
}

void open_chain(const Picture& picture, const ScreenState& state, ScreenSize size, std::vector<ScreenLine>& lines) {
  const std::size_t end = size.rows - 1;
  const view::Chain& chain = picture.chains[std::min(state.selected, picture.chains.size() - 1)];
  lines.push_back({{shortened(printable(chain.path), size.columns, state.unicode), Style::kTitle}});
  lines.push_back({{"response now ", Style::kPlain},
                   {figure(chain.newest_ms), style_of(chain, chain.newest_ms.value_or(0.0))},
                   {fmt::format(" ms, expected {}, promised {}, bound {}", figure(chain.expected_ms),
                                figure(chain.promised_ms), figure(chain.bound_ms)),
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
  std::vector<Section> sections{summaries(chain, state, size.columns),
                                node_section(nodes, picture, state, size.columns)};
  sections[1].min = sections[1].lines.size();
  if (!state.causes.empty()) {
    Section causes{{}, 0, 0};
    for (const std::string& line : state.causes) {
      causes.lines.push_back({{line, causes.lines.empty() ? Style::kHeading : Style::kPlain}});
    }
    causes.min = causes.lines.size();
    sections.push_back(std::move(causes));
  }
  std::size_t taken = lines.size();
  for (const Section& section : sections) taken += section.lines.size();
  const std::size_t left = end > taken + 1 ? end - taken - 1 : 1;
  sections.push_back(distribution_section(chain.distribution, left, size.columns, state.unicode));
  place(std::move(sections), end > lines.size() ? end - lines.size() : 0, state.unicode, lines);
}

std::vector<ScreenLine> help_lines() {
  const auto line = [](const char* text) { return ScreenLine{{text, Style::kPlain}}; };
  return {line(""),
          line("up, down   select a chain            Enter   open it"),
          line("Esc        back                      q       quit"),
          line("p          pause, or go on           s, S    sort subchains; reverse"),
          line("w          in an opened chain: why its responses were late"),
          line(""),
          line("Figures are of the last 10 s. 'late' of a chain: over its bound; if it has none,"),
          line("over what was promised. 'late' of a subchain: took longer than was promised."),
          line("'prio': p3 a fixed priority, 1/4 a share of a frame's slot, own: cores of its own."),
          line("'used': CPU time of a run, beside the 'budget' that is planned. 'stolen': how"),
          line("often a late subchain went on in its slot. docs/top.md explains the rest.")};
}

std::vector<Section> all_sections(const Picture& picture, const ScreenState& state, std::size_t width) {
  std::vector<const view::Node*> nodes;
  for (const view::Node& node : picture.nodes) nodes.push_back(&node);
  std::vector<Section> sections;
  if (!picture.chains.empty()) sections.push_back(chain_section(picture, state, width));
  Section causes = cause_section(picture, state, width);
  if (!causes.lines.empty()) sections.push_back(std::move(causes));
  sections.push_back(subchain_section(picture, state, width));
  sections.push_back(core_section(picture, state, width));
  sections.push_back(event_section(picture, width));
  sections.push_back(node_section(nodes, picture, state, width));
  return sections;
}

}  // namespace

bool press(ScreenState& state, int key, std::size_t chains) {
  if (state.help && key != 'q') {
    state.help = false;
    return true;
  }
  switch (key) {
    case 'p':
      state.paused = !state.paused;
      return true;
    case 's':
      state.sort = state.sort == SortBy::kPeriod ? SortBy::kApp : static_cast<SortBy>(static_cast<int>(state.sort) + 1);
      return true;
    case 'S':
      state.reversed = !state.reversed;
      return true;
    case 'h':
    case '?':
      state.help = true;
      return true;
    case kKeyUp:
      if (state.selected > 0) --state.selected;
      state.causes.clear();
      return true;
    case kKeyDown:
      if (state.selected + 1 < chains) ++state.selected;
      state.causes.clear();
      return true;
    case kKeyEnter:
      state.open = chains > 0;
      return true;
    case kKeyEscape:
      state.open = false;
      state.causes.clear();
      return true;
    default:
      return false;
  }
}

std::vector<ScreenLine> top_screen(const Picture& picture, const ScreenState& state, ScreenSize size) {
  if (size.rows == 0) return {};
  const bool open = state.open && !picture.chains.empty();
  std::vector<ScreenLine> lines = top_lines(picture, state);
  const std::size_t end = size.rows - 1;  // the last line is for the keys
  if (state.help) {
    for (ScreenLine& line : help_lines()) lines.push_back(std::move(line));
  } else if (open) {
    open_chain(picture, state, size, lines);
  } else {
    place(all_sections(picture, state, size.columns), end > lines.size() ? end - lines.size() : 0, state.unicode,
          lines);
  }
  lines.resize(end);  // also cuts off a screen that is too long
  const char* const keys = state.help ? "any key: back   q quit"
                           : open     ? "Esc back   up/down another chain   w why late   p pause   h help   q quit"
                                      : "up/down, Enter open a chain   s/S sort subchains   p pause   h help   q quit";
  lines.push_back({{keys, Style::kDim}});
  for (ScreenLine& line : lines) line = cut_off(std::move(line), size.columns);
  return lines;
}

std::string top_text(const Picture& picture) {
  ScreenState state;
  state.selected = picture.chains.size();  // none
  constexpr std::size_t kWide = 1000;
  std::vector<ScreenLine> lines = top_lines(picture, state);
  for (Section& section : all_sections(picture, state, kWide)) {
    lines.emplace_back();
    for (ScreenLine& line : section.lines) lines.push_back(std::move(line));
  }
  std::string text;
  for (const ScreenLine& line : lines) {
    std::string whole;
    for (const Span& span : line) whole += span.text;
    whole.erase(whole.find_last_not_of(' ') + 1);
    text += whole + "\n";
  }
  return text;
}

}  // namespace ctn::tool
