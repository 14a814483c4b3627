#include "runtime/measurements.h"

#include <algorithm>
#include <chrono>

#include "base/statistics.h"

namespace ctn::runtime {

void SampleWindow::add(Nanos sample) {
  ++count_;
  if (samples_.size() < kSamples) {
    samples_.push_back(to_millis(sample).count());
  } else {
    samples_[next_] = to_millis(sample).count();
    next_ = (next_ + 1) % kSamples;
  }
}

Summary SampleWindow::summary_ms() const {
  Summary summary = summarize(samples_);
  summary.count = count_;
  return summary;
}

void show_plan(const graph::App& app, const plan::Plan& plan, Snapshot& snapshot) {
  snapshot.relax_factor = plan.relax_factor;
  for (const plan::RelaxedBound& bound : plan.relaxed) {
    snapshot.relaxed.push_back({bound.key, bound.asked.count(), bound.planned.count()});
  }
  for (const plan::AssumedCost& assumed : plan.assumed) {
    snapshot.assumed.push_back({app.graph.node(assumed.node).name, assumed.cost.count()});
  }
}

Measurements::Measurements(const graph::App& app, TimePoint warm_from)
    : app_(app), warm_from_(warm_from), metrics_(app, {.begin = warm_from}), predicted_(app, warm_from) {}

void Measurements::cpus_in_use(const os::CpuSet& cpus) {
  const std::lock_guard lock(mutex_);
  cpus_ = cpus;
}

void Measurements::add(std::span<const record::Run> runs) {
  const std::lock_guard lock(mutex_);
  for (const record::Run& run : runs) metrics_.add(run);
}

void Measurements::clock_read(const record::ClockReading& reading) {
  const std::lock_guard lock(mutex_);
  metrics_.set_clock(reading.node, reading.ticks);
}

void Measurements::plan_in_force(TimePoint since, const plan::Plan& plan) {
  const std::lock_guard lock(mutex_);
  predicted_.in_force(since, plan);
  plan_ = plan;
  ++plans_;
}

void Measurements::no_plan_in_force() {
  const std::lock_guard lock(mutex_);
  plan_.reset();
}

void Measurements::cost_changes(std::uint64_t count) {
  const std::lock_guard lock(mutex_);
  cost_changes_ = count;
}

void Measurements::planned(const policy::PlanningBudget& budget) {
  const std::lock_guard lock(mutex_);
  totals_.plans_made = budget.plans();
  totals_.planning_cpu = budget.spent();
}

void Measurements::starved(std::uint64_t times, Nanos total) {
  const std::lock_guard lock(mutex_);
  totals_.starved = times;
  totals_.starved_for = total;
}

void Measurements::over_budget() {
  const std::lock_guard lock(mutex_);
  ++budget_overruns_;
}

record::Totals Measurements::totals() const {
  const std::lock_guard lock(mutex_);
  return totals_;
}

void Measurements::fill(Snapshot& snapshot, TimePoint now, std::optional<double> hand_set_hz) const {
  const std::lock_guard lock(mutex_);
  snapshot.warmed_up = now >= warm_from_;
  snapshot.cpus = cpus_.cpus();
  snapshot.plans = plans_;
  snapshot.cost_changes = cost_changes_;
  snapshot.budget_overruns = budget_overruns_;
  snapshot.planning_ms = to_millis(totals_.planning_cpu).count();
  snapshot.starved = totals_.starved;
  snapshot.starved_ms = to_millis(totals_.starved_for).count();
  if (plan_) show_plan(app_, *plan_, snapshot);

  // Before anything is measured, the predictions are those of the plan in force.
  plan::Predictions predicted = predicted_.until(now);
  if (predicted.plans == 0) predicted = predicted_.current().value_or(std::move(predicted));
  snapshot.source_hz = hand_set_hz.value_or(predicted.source_hz.value_or(0.0));
  std::size_t index = 0;
  for (const record::MeasuredChain<SampleWindow>& chain : metrics_.chains()) {
    ChainSnapshot& shown = snapshot.chains.emplace_back();
    for (const NodeId node : chain.term->path) shown.path.push_back(app_.graph.node(node).name);
    shown.response_ms = chain.response.summary_ms();
    shown.latency_ms = chain.latency.summary_ms();
    shown.period_ms = chain.period.summary_ms();
    if (const auto& prediction = predicted.chains[index++]) shown.predicted_response_ms = prediction->response_ms;
  }
  const double measured_for = std::chrono::duration<double>(std::max(now - warm_from_, Nanos{0})).count();
  for (std::size_t i = 0; i < app_.graph.nodes().size(); ++i) {
    const graph::Node& node = app_.graph.nodes()[i];
    if (node.external) continue;
    const record::MeasuredNode<SampleWindow>& measured = metrics_.node(NodeId(i));
    const double rate = measured_for > 0.0 ? static_cast<double>(measured.runs) / measured_for : 0.0;
    snapshot.nodes.push_back({node.name, measured.compute.summary_ms(), rate});
  }
  for (const record::MeasuredEdge<SampleWindow>& edge : metrics_.edges()) {
    snapshot.ages.push_back({app_.graph.node(edge.edge->from).name, app_.graph.node(edge.edge->to).name,
                             to_millis(edge.edge->age_limit->max_age).count(),
                             edge.edge->age_limit->on_stale == graph::OnStale::kSkip, edge.runs, edge.stale,
                             edge.age.summary_ms()});
  }
}

}  // namespace ctn::runtime
