// What was measured while an app runs, in life and in the simulator: for snapshots (catan/snapshot.h), and for the
// outcome of a simulation (sim/outcome.h). What is planned with is not here (planning_loop.h).
//
// `Samples` is where durations go, as record/run_metrics.h has it.
//
// Units: Nanos in, milliseconds out. Thread safety: each call locks, but for those that give a reference.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

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

template <class Samples>
class Measurements {
 public:
  // Samples that go back to a time before `warm_from` are left out. `app` outlives it.
  Measurements(const graph::App& app, TimePoint warm_from)
      : app_(app), warm_from_(warm_from), metrics_(app, {.begin = warm_from}), predicted_(app, warm_from) {}

  // A run has ended; each after those it consumed.
  void ran(const record::Run& run) {
    const std::lock_guard lock(mutex_);
    metrics_.add(run);
  }
  // What is known of a clock of others from now on.
  void clock_read(const record::ClockReading& reading) {
    const std::lock_guard lock(mutex_);
    metrics_.set_clock(reading.node, reading.ticks);
  }
  // Predictions are averaged over the time they were in force, from `warm_from` on.
  void plan_in_force(TimePoint since, const plan::Plan& plan) {
    const std::lock_guard lock(mutex_);
    predicted_.in_force(since, plan);
    plan_ = plan;
    ++counts_.plans;
  }
  // What is in force follows no plan.
  void no_plan_in_force() {
    const std::lock_guard lock(mutex_);
    plan_.reset();
  }
  void triggered(TimePoint at) { count(counts_.triggers, at >= warm_from_); }
  void stole(TimePoint begin) { count(counts_.steals, begin >= warm_from_); }
  void cost_changed() { count(counts_.cost_changes, true); }
  void hang_began() { count(counts_.hangs, true); }
  void over_budget() { count(counts_.budget_overruns, true); }

  // These CPUs are planned for.
  void cpus_in_use(const os::CpuSet& cpus) {
    const std::lock_guard lock(mutex_);
    cpus_ = cpus;
  }
  // What re-planning has taken, so far.
  void planned(std::uint64_t plans, Nanos cpu) {
    const std::lock_guard lock(mutex_);
    totals_.plans_made = plans;
    totals_.planning_cpu = cpu;
  }
  // CPUs were kept from real-time threads so often, and so long, so far.
  void starved(std::uint64_t times, Nanos total) {
    const std::lock_guard lock(mutex_);
    totals_.starved = times;
    totals_.starved_for = total;
  }

  // Fills all but policy, real_time, changes and notices, as of `now`. `asked`: the app, with the weights and bounds
  // that hold. `hand_set_hz`: where no plan tells.
  void fill(Snapshot& snapshot, TimePoint now, const graph::App& asked, std::optional<double> hand_set_hz) const;
  // What the record ends with.
  record::Totals totals() const {
    const std::lock_guard lock(mutex_);
    return totals_;
  }

  // --- where nobody else uses it meanwhile ---
  TimePoint warm_from() const { return warm_from_; }
  const record::RunMetrics<Samples>& metrics() const { return metrics_; }
  const plan::PredictedMeans& predicted() const { return predicted_; }
  const Counts& counts() const { return counts_; }

 private:
  void count(std::uint64_t& counter, bool counts) {
    const std::lock_guard lock(mutex_);
    counter += counts ? 1U : 0U;
  }

  const graph::App& app_;
  const TimePoint warm_from_;
  mutable std::mutex mutex_;  // guards what follows
  record::RunMetrics<Samples> metrics_;
  plan::PredictedMeans predicted_;
  std::optional<plan::Plan> plan_;  // in force
  os::CpuSet cpus_;
  Counts counts_;
  record::Totals totals_;
};

template <class Samples>
void Measurements<Samples>::fill(Snapshot& snapshot, TimePoint now, const graph::App& asked,
                                 std::optional<double> hand_set_hz) const {
  const std::lock_guard lock(mutex_);
  snapshot.warmed_up = now >= warm_from_;
  snapshot.cpus = cpus_.cpus();
  snapshot.plans = counts_.plans;
  snapshot.cost_changes = counts_.cost_changes;
  snapshot.budget_overruns = counts_.budget_overruns;
  snapshot.planning_ms = to_millis(totals_.planning_cpu).count();
  snapshot.starved = totals_.starved;
  snapshot.starved_ms = to_millis(totals_.starved_for).count();
  if (plan_) show_plan(app_, *plan_, snapshot);

  // Before anything is measured, the predictions are those of the plan in force.
  plan::Predictions predicted = predicted_.until(now);
  if (predicted.plans == 0) predicted = predicted_.current().value_or(std::move(predicted));
  snapshot.source_hz = hand_set_hz.value_or(predicted.source_hz.value_or(0.0));
  std::size_t index = 0;
  for (const record::MeasuredChain<Samples>& chain : metrics_.chains()) {
    ChainSnapshot& shown = snapshot.chains.emplace_back();
    for (const NodeId node : chain.term->path) shown.path.push_back(app_.graph.node(node).name);
    shown.response_ms = chain.response.summary_ms();
    shown.latency_ms = chain.latency.summary_ms();
    shown.period_ms = chain.period.summary_ms();
    if (const auto& prediction = predicted.chains[index++]) shown.predicted_response_ms = prediction->response_ms;
  }
  const double measured_s = std::chrono::duration<double>(std::max(now - warm_from_, Nanos{0})).count();
  for (std::size_t i = 0; i < app_.graph.nodes().size(); ++i) {
    const graph::Node& node = app_.graph.nodes()[i];
    if (node.external) continue;
    const record::MeasuredNode<Samples>& measured = metrics_.node(NodeId(i));
    const double rate = measured_s > 0.0 ? static_cast<double>(measured.runs) / measured_s : 0.0;
    snapshot.nodes.push_back({node.name, measured.compute.summary_ms(), rate});
  }
  snapshot.ages = metrics_.ages(app_.graph);
  show_asked(asked, snapshot);
}

}  // namespace ctn::driver
