#include "top_main_screen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "base/text.h"
#include "os/cpu_set.h"
#include "top_figures.h"
#include "top_table.h"

namespace ctn::tool {
namespace {

using view::Picture;

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
  std::string text = fmt::format("objective {}", short_figure(picture.objective));
  if (picture.plan) {
    text += fmt::format(", planned {}; plan {} old ({}), {} made", short_figure(picture.plan->objective),
                        duration_text(picture.up_s - picture.plan->at_s), printable(picture.plan->reason),
                        picture.plans_made);
  } else {
    text += "; no plan in force";
  }
  ScreenLine line{{std::move(text), Style::kPlain}};
  if (picture.starved > 0) {
    line.push_back(
        {fmt::format("; starved {}x, {} ms", picture.starved, short_figure(picture.starved_ms)), Style::kWarning});
  }
  return line;
}

std::string bound_text(const view::RelaxedBound& bound) {
  if (bound.bound.ends_with(".min_rate")) {
    return fmt::format("{} {} Hz, not {} Hz", printable(bound.bound), short_figure(1000.0 / bound.planned_ms),
                       short_figure(1000.0 / bound.asked_ms));
  }
  return fmt::format("{} {} ms, not {} ms", printable(bound.bound), short_figure(bound.planned_ms),
                     short_figure(bound.asked_ms));
}

ScreenSection chain_section(const Picture& picture, const ScreenState& state, std::size_t width) {
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
               {short_figure(chain.newest_ms), response_style(chain, chain.newest_ms.value_or(0.0))},
               {short_figure(response, &Summary::mean)},
               {short_figure(chain.expected_ms), Style::kDim},
               {short_figure(response, &Summary::p95), response_style(chain, response.p95)},
               {short_figure(response, &Summary::max)},
               {short_figure(chain.promised_ms), Style::kDim},
               {short_figure(chain.bound_ms), Style::kDim},
               chain.bound_ms ? count_text(chain.over_bound, Style::kBad) : count_text(chain.over_promise),
               {std::to_string(response.count), Style::kDim},
               {short_figure(response, &Summary::p50)},
               {short_figure(response, &Summary::p99)},
               {fmt::format("{:.3g}", chain.weight), Style::kDim},
               {sparkline(chain.worst_ms, drawn, state.unicode), Style::kGood}},
              index == state.selected);
  }
  return {table.lines(width, state.unicode), 5, state.selected};
}

// Adds nothing where no response was late.
ScreenSection cause_section(const Picture& picture, const ScreenState& state, std::size_t width) {
  ScreenSection section;
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

std::string cores_text(const view::Subchain& subchain) {
  return subchain.cores.empty() ? "-" : os::to_string(os::CpuSet(subchain.cores));
}

ScreenSection subchain_section(const Picture& picture, const ScreenState& state, std::size_t width) {
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
                            {short_figure(subchain.period_ms, &Summary::mean)},
                            {short_figure(subchain.expected_period_ms), Style::kDim},
                            {short_figure(subchain.used_ms, &Summary::p95), over ? Style::kWarning : Style::kPlain},
                            {short_figure(subchain.budget_ms), Style::kDim},
                            count_text(subchain.late),
                            count_text(subchain.stolen),
                            {percent_text(cpu_of(picture, index))},
                            {std::to_string(subchain.runs), Style::kDim},
                            count_text(subchain.overruns),
                            {short_figure(subchain.execution_ms, &Summary::p95)},
                            {short_figure(subchain.promised_execution_ms), Style::kDim},
                            {short_figure(subchain.trigger_late_ms, &Summary::p95)},
                            count_text(subchain.stole, Style::kPlain),
                            {fmt::format("{:.3g}", subchain.weight), Style::kDim}};
    if (subchain.absent) {
      cells[3] = {subchain.silent_ms ? "silent " + duration_text(*subchain.silent_ms / 1000.0) : "no run", Style::kBad};
    }
    table.add(std::move(cells));
  }
  return {table.lines(width, state.unicode), 6, 0};
}

ScreenSection core_section(const Picture& picture, const ScreenState& state, std::size_t width) {
  ScreenSection section{{{{"CORE   shared by    busy", Style::kHeading}}}, 4, 0};
  for (const view::Core& core : picture.cores) {
    const std::string cpu = core.cpu ? fmt::format("CPU {}", *core.cpu) : "CPU ?";
    std::string sharing = core.sharing == view::Sharing::kNone ? "-" : to_string(core.sharing);
    if (core.frame_ms) sharing = fmt::format("frames {}", short_figure(*core.frame_ms));
    ScreenLine line{{fmt::format("{:<6} {:<12} ", cpu, sharing), Style::kPlain},
                    {bar_text(core.busy, width >= 110 ? 20 : 10, state.unicode), Style::kGood},
                    {fmt::format(" {:>5} ", percent_text(core.busy)), Style::kPlain}};
    for (const view::CoreUse& use : core.uses) {
      std::string text = fmt::format(" {} {}", printable(use.name), percent_text(use.cores));
      if (use.slots && width >= 110) text += fmt::format(" (slots {})", percent_text(*use.slots));
      line.push_back({std::move(text), use.planned ? Style::kPlain : Style::kDim});
    }
    section.lines.push_back(cut_off(std::move(line), width));
  }
  return section;
}

Style style_of(const view::Event& event) {
  if (event.kind == "plan" || event.kind == "cost-change" || event.kind == "changed") return Style::kPlain;
  const bool bad = event.kind == "watchdog" || event.kind == "node-left" || event.kind == "replan-failed" ||
                   event.kind == "lost-reports" || event.kind == "starved" || event.kind == "ordinary-threads";
  return bad ? Style::kBad : Style::kWarning;
}

ScreenSection event_section(const Picture& picture, std::size_t width) {
  ScreenSection section{{{{"NOTICE, the newest first", Style::kHeading}}}, 4, 0};
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

}  // namespace

std::vector<ScreenLine> heading_lines(const Picture& picture, const ScreenState& state) {
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

std::vector<ScreenSection> main_sections(const Picture& picture, const ScreenState& state, std::size_t width) {
  std::vector<const view::Node*> nodes;
  for (const view::Node& node : picture.nodes) nodes.push_back(&node);
  std::vector<ScreenSection> sections;
  if (!picture.chains.empty()) sections.push_back(chain_section(picture, state, width));
  ScreenSection causes = cause_section(picture, state, width);
  if (!causes.lines.empty()) sections.push_back(std::move(causes));
  sections.push_back(subchain_section(picture, state, width));
  sections.push_back(core_section(picture, state, width));
  sections.push_back(event_section(picture, width));
  sections.push_back(node_section(nodes, picture, state, width));
  return sections;
}

}  // namespace ctn::tool
