#include "plan/predicted_means.h"

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace ctn::plan {

Predictions predictions_of(const Plan& plan, const graph::App& app) {
  Predictions figures;
  figures.plans = 1;
  figures.objective = plan.expected ? plan.expected->objective : plan.objective;
  figures.relax_factor = plan.relax_factor;
  figures.for_typical = plan.for_typical;
  for (const graph::Term& term : app.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    const std::size_t index = figures.chains.size();
    std::optional<ChainPrediction>& predicted = figures.chains.emplace_back();
    if (index >= plan.chains.size() || plan.chains[index].path != term.path) continue;
    const ChainPlan& chain = plan.chains[index];
    const Expectation::Chain shown =
        plan.expected ? plan.expected->chains[index] : Expectation::Chain{chain.response, chain.latency, chain.period};
    predicted = {shown.response.count(), shown.latency.count(), shown.period.count(), chain.response.count()};
  }
  figures.rate_hz.resize(app.graph.nodes().size());
  for (std::size_t node = 0; node < figures.rate_hz.size(); ++node) {
    const std::optional<SubchainId> subchain = app.graph.nodes()[node].subchain;
    if (!subchain || subchain->index() >= plan.subchains.size()) continue;
    const Millis period = usual_timing(plan, *subchain).period;
    if (period > Millis{0}) figures.rate_hz[node] = Rate::every(period).hertz();
  }
  if (!app.graph.subchains().empty()) {
    figures.source_hz = figures.rate_hz[app.graph.subchains().front().nodes.front().index()];
  }
  return figures;
}

PredictedMeans::PredictedMeans(const graph::App& app, TimePoint from) : app_(app), from_(from) {
  const auto chains = std::count_if(app.objective.begin(), app.objective.end(), [](const graph::Term& term) {
    return term.metric == graph::Metric::kResponseTime;
  });
  past_.chains.resize(static_cast<std::size_t>(chains));
  past_.rates.resize(app.graph.nodes().size());
}

void PredictedMeans::Mean::add(std::optional<double> value, double seconds) {
  if (!value) return;
  sum += seconds * *value;
  weight += seconds;
}

void PredictedMeans::in_force(TimePoint since, const Plan& plan) {
  add_current(past_, since);
  current_ = predictions_of(plan, app_);
  current_since_ = since;
}

void PredictedMeans::add_current(Means& means, TimePoint end) const {
  const TimePoint begin = std::max(current_since_, from_);
  if (!current_ || end <= begin) return;
  const double seconds = in_seconds(end - begin);
  ++means.plans;
  means.objective.add(current_->objective, seconds);
  means.relax_factor = std::max(means.relax_factor, current_->relax_factor);
  means.for_typical = means.for_typical || current_->for_typical;
  for (std::size_t index = 0; index < means.chains.size(); ++index) {
    const std::optional<ChainPrediction>& chain = current_->chains[index];
    if (!chain) continue;
    means.chains[index].response.add(chain->response_ms, seconds);
    means.chains[index].latency.add(chain->latency_ms, seconds);
    means.chains[index].period.add(chain->period_ms, seconds);
    means.chains[index].promised.add(chain->promised_response_ms, seconds);
  }
  for (std::size_t node = 0; node < means.rates.size(); ++node) means.rates[node].add(current_->rate_hz[node], seconds);
}

Predictions PredictedMeans::until(TimePoint end) const {
  Means means = past_;
  add_current(means, end);
  Predictions result;
  result.plans = means.plans;
  result.objective = means.objective.value();
  result.relax_factor = means.relax_factor;
  result.for_typical = means.for_typical;
  for (const ChainMeans& chain : means.chains) {
    const std::optional<double> response = chain.response.value();
    result.chains.push_back(response ? std::optional(ChainPrediction{*response, *chain.latency.value(),
                                                                     *chain.period.value(), *chain.promised.value()})
                                     : std::nullopt);
  }
  for (const Mean& rate : means.rates) result.rate_hz.push_back(rate.value());
  if (!app_.graph.subchains().empty()) {
    result.source_hz = result.rate_hz[app_.graph.subchains().front().nodes.front().index()];
  }
  return result;
}

}  // namespace ctn::plan
