#include "plan/predict.h"

#include <algorithm>
#include <utility>

#include "model/evaluate.h"
#include "plan/limits.h"

namespace ctn::plan {
namespace {

std::vector<model::SubchainTiming> timings_of(std::span<const SubchainPlan> subchains) {
  std::vector<model::SubchainTiming> timings;
  timings.reserve(subchains.size());
  for (const SubchainPlan& subchain : subchains) timings.push_back({subchain.period, subchain.execution});
  return timings;
}

}  // namespace

Prediction predict(const graph::App& app, const model::CostTable& costs, std::span<const SubchainPlan> subchains) {
  const std::vector<model::SubchainTiming> timings = timings_of(subchains);
  Prediction prediction;
  std::vector<Millis> of_term;  // the figure that the term weighs
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kPeriod) {
      of_term.push_back(model::evaluate_period(app.graph, term.path.front(), timings));
      prediction.nodes.push_back({term.path.front(), of_term.back(), term.weight});
    } else {
      const model::ChainTiming timing = model::evaluate_chain(app.graph, term.path, costs, timings);
      of_term.push_back(timing.response);
      prediction.chains.push_back({term.path, timing.response, timing.latency, timing.period, term.weight});
    }
    prediction.objective += term.weight * of_term.back().count();
  }
  for (const SoftBound& bound : soft_bounds(app)) {
    const Millis planned = bound.term ? of_term[*bound.term] : model::evaluate_period(app.graph, *bound.node, timings);
    if (planned <= bound.asked * (1.0 + kTolerance)) continue;
    prediction.relaxed.push_back({bound.key, bound.asked, planned});
    prediction.relax_factor = std::max(prediction.relax_factor, planned / bound.asked);
  }
  return prediction;
}

void fill_predictions(Plan& plan, const graph::App& app, const model::CostTable& costs) {
  Prediction prediction = predict(app, costs, plan.subchains);
  plan.chains = std::move(prediction.chains);
  plan.nodes = std::move(prediction.nodes);
  plan.objective = prediction.objective;
  plan.relax_factor = prediction.relax_factor;
  plan.relaxed = std::move(prediction.relaxed);
}

}  // namespace ctn::plan
