// What was measured while an app runs, in life and in the simulator: for snapshots (catan/snapshot.h), and for the
// outcome of a simulation (sim/outcome.h). What is planned with is not here (planning_loop.h).
//
// `Samples` is where durations go, as record/run_metrics.h has it.
//
// Units: Nanos in, milliseconds out. Thread safety: each call locks.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/guarded.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "os/cpu_set.h"
#include "plan/plan.h"
#include "plan/predicted_means.h"
#include "record/events.h"
#include "record/run_metrics.h"
#include "record/writer.h"

namespace ctn::driver {

// How often what happened. Of triggers and steals: since what is measured begins.
struct Counts {
  std::uint64_t plans = 0;  // that came into force
  std::uint64_t cost_changes = 0;
  std::uint64_t hangs = 0;
  std::uint64_t budget_overruns = 0;  // runs that were demoted
  std::uint64_t triggers = 0;
  std::uint64_t steals = 0;
};

// What the plan in force says of its bounds and of what its nodes cost.
void show_plan(const graph::App& app, const plan::Plan& plan, Snapshot& snapshot);
// What is asked for: weights and bounds. Precondition: the snapshot has its nodes.
void show_asked(const graph::App& asked, Snapshot& snapshot);

// What is known at one time.
template <class Samples>
struct Figures {
  Figures(const graph::App& app, TimePoint warm_from) : metrics(app, {.begin = warm_from}), predicted(app, warm_from) {}

  record::RunMetrics<Samples> metrics;
  plan::PredictedMeans predicted;
  std::optional<plan::Plan> plan{};  // in force
  os::CpuSet cpus{};                 // that are planned for
  Counts counts{};
  record::Totals totals{};
};

template <class Samples>
class Measurements {
 public:
  // Samples that go back to a time before `warm_from` are left out. `app` outlives it.
  Measurements(const graph::App& app, TimePoint warm_from)
      : app_(app), warm_from_(warm_from), figures_(app, warm_from) {}

  // A run has ended; each after those it consumed.
  void ran(const record::Run& run) { figures_.lock()->metrics.add(run); }
  // What is known of a clock of others from now on.
  void clock_read(const record::ClockReading& reading) {
    figures_.lock()->metrics.set_clock(reading.node, reading.ticks);
  }
  // Predictions are averaged over the time they were in force, from `warm_from` on.
  void plan_in_force(TimePoint since, const plan::Plan& plan) {
    const auto figures = figures_.lock();
    figures->predicted.in_force(since, plan);
    figures->plan = plan;
    ++figures->counts.plans;
  }
  // What is in force follows no plan.
  void no_plan_in_force() { figures_.lock()->plan.reset(); }
  void triggered(TimePoint at) { figures_.lock()->counts.triggers += at >= warm_from_ ? 1U : 0U; }
  void stole(TimePoint begin) { figures_.lock()->counts.steals += begin >= warm_from_ ? 1U : 0U; }
  void cost_changed() { ++figures_.lock()->counts.cost_changes; }
  void hang_began() { ++figures_.lock()->counts.hangs; }
  void over_budget() { ++figures_.lock()->counts.budget_overruns; }

  // These CPUs are planned for.
  void cpus_in_use(const os::CpuSet& cpus) { figures_.lock()->cpus = cpus; }
  // What re-planning has taken, so far.
  void planned(std::uint64_t plans, Nanos cpu) {
    const auto figures = figures_.lock();
    figures->totals.plans_made = plans;
    figures->totals.planning_cpu = cpu;
  }
  // CPUs were kept from real-time threads so often, and so long, so far.
  void starved(std::uint64_t times, Nanos total) {
    const auto figures = figures_.lock();
    figures->totals.starved = times;
    figures->totals.starved_for = total;
  }

  // Fills all but policy, real_time, changes and notices, as of `now`. `asked`: the app, with the weights and bounds
  // that hold. `hand_set_hz`: where no plan tells.
  void fill(Snapshot& snapshot, TimePoint now, const graph::App& asked, std::optional<double> hand_set_hz) const;
  TimePoint warm_from() const { return warm_from_; }
  // All figures, which no other thread reads or changes while what it returns is kept.
  auto lock() const { return figures_.lock(); }

 private:
  const graph::App& app_;
  const TimePoint warm_from_;
  Guarded<Figures<Samples>> figures_;
};

template <class Samples>
void Measurements<Samples>::fill(Snapshot& snapshot, TimePoint now, const graph::App& asked,
                                 std::optional<double> hand_set_hz) const {
  const auto figures = lock();
  snapshot.warmed_up = now >= warm_from_;
  snapshot.cpus = figures->cpus.cpus();
  snapshot.plans = figures->counts.plans;
  snapshot.cost_changes = figures->counts.cost_changes;
  snapshot.budget_overruns = figures->counts.budget_overruns;
  snapshot.planning_ms = to_millis(figures->totals.planning_cpu).count();
  snapshot.starved = figures->totals.starved;
  snapshot.starved_ms = to_millis(figures->totals.starved_for).count();
  if (figures->plan) show_plan(app_, *figures->plan, snapshot);

  // Before anything is measured, the predictions are those of the plan in force.
  plan::Predictions predicted = figures->predicted.until(now);
  if (predicted.plans == 0) predicted = figures->predicted.current().value_or(std::move(predicted));
  snapshot.source_hz = hand_set_hz.value_or(predicted.source_hz.value_or(0.0));
  std::size_t index = 0;
  for (const record::MeasuredChain<Samples>& chain : figures->metrics.chains()) {
    ChainSnapshot& shown = snapshot.chains.emplace_back();
    for (const NodeId node : chain.term->path) shown.path.push_back(app_.graph.node(node).name);
    shown.response_ms = chain.response.summary_ms();
    shown.latency_ms = chain.latency.summary_ms();
    shown.period_ms = chain.period.summary_ms();
    if (const auto& prediction = predicted.chains[index++]) shown.predicted_response_ms = prediction->response_ms;
  }
  const double measured_s = in_seconds(std::max(now - warm_from_, Nanos{0}));
  for (std::size_t i = 0; i < app_.graph.nodes().size(); ++i) {
    const graph::Node& node = app_.graph.nodes()[i];
    if (node.external) continue;
    const record::MeasuredNode<Samples>& measured = figures->metrics.node(NodeId(i));
    const double rate = measured_s > 0.0 ? static_cast<double>(measured.runs) / measured_s : 0.0;
    snapshot.nodes.push_back({node.name, measured.compute.summary_ms(), rate});
  }
  snapshot.ages = figures->metrics.ages(app_.graph);
  show_asked(asked, snapshot);
}

}  // namespace ctn::driver
