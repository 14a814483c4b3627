#include "runtime/collector.h"

#include <fmt/format.h>

#include <optional>
#include <span>

#include "plan/json.h"
#include "policy/hung_runs.h"

namespace ctn::runtime {

Collector::Collector(const graph::App& app, os::Os& os, Collecting from, ClockWatch& clocks, driver::PlanningLoop& loop)
    : app_(app),
      os_(os),
      from_(std::move(from)),
      clocks_(clocks),
      loop_(loop),
      check_(app.graph),
      collected_(app.graph.nodes().size()),
      stale_(app.graph) {}

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
  for (std::vector<record::Run>& runs : collected_) pass_on(runs, now);
  from_.measurements.cost_changes(loop_.cost_changes());
}

void Collector::pass_on(std::vector<record::Run>& runs, TimePoint now) {
  std::erase_if(runs, [&](record::Run& run) { return !check_.accept(run, now); });
  from_.measurements.add(runs);
  for (const record::Run& run : runs) {
    clocks_.ran(run);
    for (const record::Notice& told : stale_.ran(run)) from_.notices.add(told);
    const std::optional<record::CostChange> change = loop_.ran(run);
    if (!from_.writer) continue;
    from_.writer->add(run);
    if (change) from_.writer->add(*change);
  }
}

void Collector::triggered(const record::Trigger& trigger) {
  if (from_.writer) from_.writer->add(trigger);
}

void Collector::slot_over(const record::SlotUse& slot) {
  if (from_.writer) from_.writer->add(slot);
}

void Collector::stole(const record::Steal& steal) {
  if (from_.writer) from_.writer->add(steal);
}

void Collector::hang_changed(SubchainId subchain, bool began, TimePoint at) {
  if (began) loop_.hang_began(subchain, at);
  const record::Notice of_hang = policy::notice_of_hang(app_.graph.subchain(subchain).name, began, at);
  from_.notices.add(of_hang.kind, of_hang.detail);
}

void Collector::over_budget(const record::Overrun& overrun) {
  from_.measurements.over_budget();
  if (from_.writer) from_.writer->add(overrun);
}

void Collector::woke_late(int cpu, TimePoint due, TimePoint woke) { starvation_.woke_late(cpu, due, woke); }

void Collector::plan_in_force(const plan::Plan& plan, policy::PlanReason reason) {
  const TimePoint now = os_.now();
  from_.measurements.plan_in_force(now, plan);
  if (from_.writer) from_.writer->add(record::PlanChange{now, policy::to_string(reason), plan::to_json(plan, app_)});
}

void Collector::clock_read(const record::ClockReading& reading) {
  from_.measurements.clock_read(reading);
  if (from_.writer) from_.writer->add(reading);
}

void Collector::app_changed(const record::AppChange& change) {
  if (from_.writer) from_.writer->add(change);
}

void Collector::note_ignored_wakes() {
  std::uint64_t ignored_wakes = 0;
  for (const auto& controller : from_.controllers) ignored_wakes += controller->ignored_wakes();
  if (std::exchange(ignored_wakes_noted_, ignored_wakes) == ignored_wakes) return;
  from_.notices.add("flood",
                    fmt::format("dispatchers were woken more often than runs can end, and did not listen {} times; one "
                                "of the app's programs misbehaves",
                                ignored_wakes));
}

void Collector::check_starvation() {
  starvation_.stolen_until_now(os_.stolen_time());
  from_.measurements.starved(starvation_.times(), starvation_.total());
  if (const std::optional<std::string> news = starvation_.message(os_.now())) from_.notices.add("starved", *news);
}

void Collector::note_losses() {
  std::uint64_t losses = check_.rejected();
  for (const auto& link : from_.links) {
    if (link) losses += link->lost_reports() + link->broken_rings();
  }
  for (const auto& controller : from_.controllers) losses += controller->lost_reports();
  std::string edges;
  if (from_.dropped) {
    for (const auto& [edge, count] : from_.dropped()) {
      losses += count;
      edges += fmt::format("; {} values on {}", count, edge);
    }
  }
  if (std::exchange(losses_noted_, losses) == losses) return;
  from_.notices.add(
      "lost-reports",
      fmt::format("{} reports or values were lost: their reader did not keep up, or they could not be true{}", losses,
                  edges));
}

void Collector::write_notices() {
  for (const record::Notice& notice : from_.notices.take_unrecorded()) from_.writer->add(notice);
}

void Collector::flush() {
  if (!from_.writer) return;
  write_notices();
  const Status flushed = from_.writer->flush();
  if (flushed || std::exchange(record_failed_, true)) return;
  from_.notices.add("record-failed", flushed.error().message());
}

Status Collector::close() {
  if (!from_.writer) return Done{};
  write_notices();
  from_.writer->set_totals(from_.measurements.totals());
  Status closed = from_.writer->close(os_.now(), os_.host_facts());
  from_.writer.reset();
  return closed;
}

}  // namespace ctn::runtime
