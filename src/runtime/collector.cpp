#include "runtime/collector.h"

#include <fmt/format.h>

#include <optional>
#include <span>

namespace ctn::runtime {

Collector::Collector(const graph::App& app, os::Os& os, Reporting from, ClockWatch& clocks, Measurements& measurements,
                     EventLog& log)
    : app_(app),
      os_(os),
      from_(std::move(from)),
      clocks_(clocks),
      measurements_(measurements),
      log_(log),
      check_(app.graph),
      collected_(app.graph.nodes().size()) {}

void Collector::collect() {
  const std::span<const NodeId> order = app_.graph.topological_order();
  for (std::size_t position = order.size(); position-- > 0;) {
    collected_[position].clear();
    NodeLink* link = from_.links[order[position].index()].get();
    if (link == nullptr) continue;
    link->drain([&](record::Run run) { collected_[position].push_back(std::move(run)); });
  }
  for (const auto& controller : from_.controllers) controller->drain(*this);
  // After the rings: a node has joined before it reports.
  for (const NodeId node : from_.registered.take_joined()) check_.restart(node);
  const TimePoint now = os_.now();
  for (std::vector<record::Run>& runs : collected_) {
    for (record::Run& run : runs) {
      if (!check_.accept(run, now)) continue;
      clocks_.ran(run);
      log_.ran(run);
    }
  }
}

void Collector::note_misuses() {
  if (!from_.channels.misuses) return;
  for (record::Notice& misuse : from_.channels.misuses(os_.now())) log_.notice(std::move(misuse));
}

void Collector::note_ignored_wakes() {
  std::uint64_t ignored_wakes = 0;
  for (const auto& controller : from_.controllers) ignored_wakes += controller->ignored_wakes();
  if (std::exchange(ignored_wakes_noted_, ignored_wakes) == ignored_wakes) return;
  log_.notice({os_.now(), "flood",
               fmt::format("controllers were woken more often than runs can end, and did not listen {} times; one "
                           "of the app's programs misbehaves",
                           ignored_wakes)});
}

void Collector::check_starvation() {
  starvation_.stolen_until_now(os_.stolen_time());
  measurements_.starved(starvation_.times(), starvation_.total());
  const TimePoint now = os_.now();
  if (const std::optional<std::string> news = starvation_.message(now)) log_.notice({now, "starved", *news});
}

void Collector::note_losses() {
  std::uint64_t losses = check_.rejected();
  for (const auto& link : from_.links) {
    if (link) losses += link->lost_reports() + link->broken_rings();
  }
  for (const auto& controller : from_.controllers) losses += controller->lost_reports();
  std::string edges;
  if (from_.channels.dropped) {
    for (const auto& [edge, count] : from_.channels.dropped()) {
      losses += count;
      edges += fmt::format("; {} values on {}", count, edge);
    }
  }
  if (std::exchange(losses_noted_, losses) == losses) return;
  log_.notice({os_.now(), "lost-reports",
               fmt::format("{} reports or values were lost: their reader did not keep up, or they could not be true{}",
                           losses, edges)});
}

}  // namespace ctn::runtime
