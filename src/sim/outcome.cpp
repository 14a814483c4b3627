#include "sim/outcome.h"

#include <algorithm>
#include <chrono>

namespace ctn::sim {
namespace {

double seconds(Nanos duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

Gathering::Gathering(const graph::App& app, TimePoint warm_from)
    : app_(app), warm_from_(warm_from), nodes_(app.graph.nodes().size()) {
  for (const graph::Term& term : app.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    for (const NodeId node : term.path) nodes_[node.index()].chains.push_back(chains_.size());
    chains_.push_back({record::ChainTracker(app.graph, term.path), term.max.value_or(Nanos{0}), 0, {}, {}, {}});
  }
}

void Gathering::add(const record::Run& run) {
  Node& node = nodes_[run.node.index()];
  if (node.last_end && *node.last_end >= warm_from_) node.period.add(run.end - *node.last_end);
  node.last_end = run.end;
  if (run.begin >= warm_from_) {
    ++node.runs;
    node.outputs += run.emitted ? 1U : 0U;
    node.compute.add(run.cpu);
  }
  for (const std::size_t index : node.chains) {
    Chain& chain = chains_[index];
    for (const record::ChainSample& sample : chain.tracker.add(run)) {
      if (sample.begin >= warm_from_) chain.latency.add(sample.latency);
      if (sample.response && sample.end - *sample.response >= warm_from_) {
        chain.response.add(*sample.response);
        if (chain.bound > Nanos{0} && *sample.response > chain.bound) ++chain.over_bound;
      }
      if (sample.period && sample.end - *sample.period >= warm_from_) chain.period.add(*sample.period);
    }
  }
}

void Gathering::plan_in_force(TimePoint since, const plan::Plan& plan) {
  past_ = promised(since);
  Promise promise{1.0, plan.expected ? plan.expected->objective : plan.objective, {}, {}};
  if (!plan.subchains.empty()) {
    const Millis period = plan.expected ? plan.expected->subchains.front().period : plan.subchains.front().period;
    promise.source_hz = Rate::every(period).hertz();
  }
  for (std::size_t index = 0; index < plan.chains.size(); ++index) {
    const Millis response = plan.expected ? plan.expected->chains[index].response : plan.chains[index].response;
    promise.responses.push_back(response.count());
  }
  if (since > warm_from_) relax_factor_ = std::max(relax_factor_, relax_factor_now_);
  relax_factor_now_ = plan.relax_factor;
  current_ = std::move(promise);
  current_since_ = since;
}

Gathering::Promise Gathering::promised(TimePoint until) const {
  Promise all = past_;
  if (!current_) return all;
  const double in_force = std::max(0.0, seconds(until - std::max(current_since_, warm_from_)));
  all.seconds += in_force;
  all.objective += current_->objective * in_force;
  all.source_hz += current_->source_hz * in_force;
  all.responses.resize(current_->responses.size());
  for (std::size_t index = 0; index < all.responses.size(); ++index) {
    all.responses[index] += current_->responses[index] * in_force;
  }
  return all;
}

void Gathering::measure_objective(Outcome& outcome) const {
  double sum = 0.0;
  std::size_t chain = 0;
  for (const graph::Term& term : app_.objective) {
    const SampleSummary measured = term.metric == graph::Metric::kResponseTime
                                       ? chains_[chain++].response.summary_ms()
                                       : nodes_[term.path.front().index()].period.summary_ms();
    if (term.weight == 0.0) continue;
    if (measured.count == 0) return;
    sum += term.weight * measured.mean;
  }
  outcome.objective = sum;
}

Outcome Gathering::outcome(TimePoint end) const {
  Outcome outcome;
  outcome.app = app_.name;
  outcome.measured_s = std::max(0.0, seconds(end - warm_from_));
  outcome.triggers = triggers_;
  outcome.steals = steals_;
  const Promise promise = promised(end);
  if (promise.seconds > 0.0) {
    outcome.source_hz = promise.source_hz / promise.seconds;
  } else if (current_) {
    outcome.source_hz = current_->source_hz;
  }
  std::size_t index = 0;
  for (const graph::Term& term : app_.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    const Chain& chain = chains_[index];
    ChainOutcome& shown = outcome.chains.emplace_back();
    shown.path = app_.graph.path_name(term.path);
    shown.weight = term.weight;
    if (term.max) shown.bound_ms = to_millis(*term.max).count();
    shown.over_bound = chain.over_bound;
    shown.response_ms = chain.response.summary_ms();
    shown.latency_ms = chain.latency.summary_ms();
    shown.period_ms = chain.period.summary_ms();
    if (promise.seconds > 0.0) shown.predicted_ms = promise.responses[index] / promise.seconds;
    ++index;
  }
  if (promise.seconds > 0.0) outcome.objective_predicted = promise.objective / promise.seconds;
  outcome.relax_factor = current_ ? std::max(relax_factor_, relax_factor_now_) : 1.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const graph::Node& node = app_.graph.nodes()[i];
    if (node.external) continue;
    NodeOutcome& shown = outcome.nodes.emplace_back();
    shown.name = node.name;
    shown.runs = nodes_[i].runs;
    shown.outputs = nodes_[i].outputs;
    shown.rate_hz = outcome.measured_s > 0.0 ? static_cast<double>(shown.runs) / outcome.measured_s : 0.0;
    shown.period_ms = nodes_[i].period.summary_ms();
    shown.compute_ms = nodes_[i].compute.summary_ms();
    // A run more or less at the ends of the interval is no miss.
    const double one = outcome.measured_s > 0.0 ? 1.0 / outcome.measured_s : 0.0;
    shown.too_slow = node.min_rate && shown.rate_hz + one < node.min_rate->hertz();
    shown.too_fast = node.max_rate && shown.rate_hz - one > node.max_rate->hertz();
  }
  measure_objective(outcome);
  return outcome;
}

}  // namespace ctn::sim
