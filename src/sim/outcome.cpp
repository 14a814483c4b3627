#include "sim/outcome.h"

#include <algorithm>

namespace ctn::sim {

Outcome outcome_of(const graph::App& app, const Measurements& measured, TimePoint end) {
  Outcome outcome;
  outcome.app = app.name;
  outcome.measured_s = std::max(0.0, in_seconds(end - measured.warm_from()));
  const auto figures = measured.lock();
  const driver::Counts& counts = figures->counts;
  outcome.triggers = counts.triggers;
  outcome.steals = counts.steals;
  outcome.hangs = counts.hangs;
  outcome.budget_overruns = counts.budget_overruns;
  outcome.plans_adopted = counts.plans;
  outcome.cost_changes = counts.cost_changes;
  const record::RunMetrics<Histogram>& metrics = figures->metrics;
  const plan::Predictions predicted = figures->predicted.until(end);
  const std::optional<plan::Predictions> current = figures->predicted.current();
  outcome.source_hz = predicted.source_hz.value_or(current ? current->source_hz.value_or(0.0) : 0.0);
  outcome.objective = metrics.objective(app);
  outcome.objective_predicted = predicted.objective;
  outcome.relax_factor = std::max(predicted.relax_factor, current ? current->relax_factor : 1.0);
  std::size_t index = 0;
  for (const record::MeasuredChain<Histogram>& chain : metrics.chains()) {
    const graph::Term& term = *chain.term;
    ChainOutcome& shown = outcome.chains.emplace_back();
    shown.path = app.graph.path_name(term.path);
    shown.weight = term.weight;
    if (term.max) shown.bound_ms = to_millis(*term.max).count();
    shown.over_bound = chain.over_bound;
    shown.response_ms = chain.response.summary_ms();
    shown.latency_ms = chain.latency.summary_ms();
    shown.period_ms = chain.period.summary_ms();
    if (const auto& prediction = predicted.chains[index++]) shown.predicted_ms = prediction->response_ms;
  }
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    const graph::Node& node = app.graph.nodes()[i];
    if (node.external) continue;
    const record::MeasuredNode<Histogram>& runs = metrics.node(NodeId(i));
    NodeOutcome& shown = outcome.nodes.emplace_back();
    shown.name = node.name;
    shown.runs = runs.runs;
    shown.outputs = runs.outputs;
    shown.rate_hz = outcome.measured_s > 0.0 ? static_cast<double>(shown.runs) / outcome.measured_s : 0.0;
    shown.period_ms = runs.period.summary_ms();
    shown.compute_ms = runs.compute.summary_ms();
    if (runs.waits) shown.wait_ms = runs.wait.summary_ms();
    // A run more or less at the ends of the interval is no miss.
    const double one = outcome.measured_s > 0.0 ? 1.0 / outcome.measured_s : 0.0;
    shown.too_slow = node.min_rate && shown.rate_hz + one < node.min_rate->hertz();
    shown.too_fast = node.max_rate && shown.rate_hz - one > node.max_rate->hertz();
  }
  outcome.ages = metrics.ages(app.graph);
  return outcome;
}

}  // namespace ctn::sim
