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

namespace {

Expectation::Timing expect_owned(const Plan& plan, const graph::App& app, SubchainId id,
                                 const model::CostTable& typical) {
  const SubchainPlan& planned = plan.subchains[id.index()];
  const model::OwnedCores owned =
      model::owned_cores_with(app.graph, id, typical.on(app, app.kind_of(planned.cores.front())),
                              static_cast<int>(planned.cores.size()), planned.threads, plan.slack);
  const Millis execution = std::min(owned.execution, planned.execution);
  const PeriodLimits limits = period_limits(app.graph, id);
  if (app.scheduler.frames == graph::FrameMode::kFixed || limits.exact) return {planned.period, execution};
  return {std::min(planned.period, std::max(owned.period, limits.least)), execution};
}

}  // namespace

Expectation expect(const Plan& plan, const graph::App& app, const model::CostTable& typical) {
  Expectation expected;
  std::vector<SubchainPlan> retimed = plan.subchains;
  for (std::size_t i = 0; i < retimed.size(); ++i) {
    expected.subchains.push_back(expect_owned(plan, app, SubchainId(i), typical));
    retimed[i].period = expected.subchains.back().period;
    retimed[i].execution = expected.subchains.back().execution;
  }
  const Prediction prediction = predict(app, typical, retimed);
  expected.objective = prediction.objective;
  for (const ChainPlan& chain : prediction.chains) {
    expected.chains.push_back({chain.response, chain.latency, chain.period});
  }
  return expected;
}

}  // namespace ctn::plan
