#include "sim/outcome.h"

#include <algorithm>
#include <chrono>

namespace ctn::sim {
namespace {

double seconds(Nanos duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

OutcomeCollector::OutcomeCollector(const graph::App& app, TimePoint warm_from)
    : app_(app), warm_from_(warm_from), metrics_(app, {.begin = warm_from}), predicted_(app, warm_from) {}

void OutcomeCollector::measure_objective(Outcome& outcome) const {
  double sum = 0.0;
  std::size_t chain = 0;
  for (const graph::Term& term : app_.objective) {
    const Summary measured = term.metric == graph::Metric::kResponseTime
                                 ? metrics_.chains()[chain++].response.summary_ms()
                                 : metrics_.node(term.path.front()).period.summary_ms();
    if (term.weight == 0.0) continue;
    if (measured.count == 0) return;
    sum += term.weight * measured.mean;
  }
  outcome.objective = sum;
}

Outcome OutcomeCollector::outcome(TimePoint end) const {
  Outcome outcome;
  outcome.app = app_.name;
  outcome.measured_s = std::max(0.0, seconds(end - warm_from_));
  outcome.triggers = triggers_;
  outcome.steals = steals_;
  outcome.budget_overruns = budget_overruns_;
  const plan::Predictions predicted = predicted_.until(end);
  const std::optional<plan::Predictions> current = predicted_.current();
  outcome.source_hz = predicted.source_hz.value_or(current ? current->source_hz.value_or(0.0) : 0.0);
  outcome.objective_predicted = predicted.objective;
  outcome.relax_factor = std::max(predicted.relax_factor, current ? current->relax_factor : 1.0);
  std::size_t index = 0;
  for (const record::MeasuredChain<Histogram>& chain : metrics_.chains()) {
    const graph::Term& term = *chain.term;
    ChainOutcome& shown = outcome.chains.emplace_back();
    shown.path = app_.graph.path_name(term.path);
    shown.weight = term.weight;
    if (term.max) shown.bound_ms = to_millis(*term.max).count();
    shown.over_bound = chain.over_bound;
    shown.response_ms = chain.response.summary_ms();
    shown.latency_ms = chain.latency.summary_ms();
    shown.period_ms = chain.period.summary_ms();
    if (const auto& prediction = predicted.chains[index++]) shown.predicted_ms = prediction->response_ms;
  }
  for (std::size_t i = 0; i < app_.graph.nodes().size(); ++i) {
    const graph::Node& node = app_.graph.nodes()[i];
    if (node.external) continue;
    const record::MeasuredNode<Histogram>& measured = metrics_.node(NodeId(i));
    NodeOutcome& shown = outcome.nodes.emplace_back();
    shown.name = node.name;
    shown.runs = measured.runs;
    shown.outputs = measured.outputs;
    shown.rate_hz = outcome.measured_s > 0.0 ? static_cast<double>(shown.runs) / outcome.measured_s : 0.0;
    shown.period_ms = measured.period.summary_ms();
    shown.compute_ms = measured.compute.summary_ms();
    if (measured.waits) shown.wait_ms = measured.wait.summary_ms();
    // A run more or less at the ends of the interval is no miss.
    const double one = outcome.measured_s > 0.0 ? 1.0 / outcome.measured_s : 0.0;
    shown.too_slow = node.min_rate && shown.rate_hz + one < node.min_rate->hertz();
    shown.too_fast = node.max_rate && shown.rate_hz - one > node.max_rate->hertz();
  }
  for (const record::MeasuredEdge<Histogram>& edge : metrics_.edges()) {
    outcome.ages.push_back({.from = app_.graph.node(edge.edge->from).name,
                            .to = app_.graph.node(edge.edge->to).name,
                            .max_age_ms = to_millis(edge.edge->age_limit->max_age).count(),
                            .skips = edge.edge->age_limit->on_stale == graph::OnStale::kSkip,
                            .runs = edge.runs,
                            .stale = edge.stale,
                            .age_ms = edge.age.summary_ms()});
  }
  measure_objective(outcome);
  return outcome;
}

}  // namespace ctn::sim
