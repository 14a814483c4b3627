#include "planner/explain.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "plan/limits.h"
#include "plan/predict.h"
#include "planner/instance.h"
#include "planner/reasons.h"
#include "planner/runner_up.h"

namespace ctn::planner {
namespace {

// Where a plan could not be proven with all its effort, its variations cannot either: they get this part of it, lest an
// explanation take a minute.
constexpr std::size_t kHurry = 4;

std::vector<Millis> terms_of(const graph::App& app, const plan::Plan& plan) {
  std::vector<Millis> values;
  std::size_t chains = 0;
  std::size_t nodes = 0;
  for (const graph::Term& term : app.objective) {
    values.push_back(term.metric == graph::Metric::kPeriod ? plan.nodes[nodes++].period
                                                           : plan.chains[chains++].response);
  }
  return values;
}

graph::App without(const graph::App& app, const plan::SoftBound& bound) {
  graph::App other = app;
  if (bound.term) {
    other.objective[*bound.term].max.reset();
  } else {
    other.graph = app.graph.without_min_rate(*bound.node);
  }
  return other;
}

class Explaining {
 public:
  Explaining(const graph::App& app, const model::CostTable& costs, const Request& request, const plan::Plan& plan)
      : app_(app),
        costs_(costs),
        request_(request),
        plan_(plan),
        instance_(make_instance(app, costs, request.cores, request.slack)) {
    request_.warm = &plan;
    if (plan.quality == plan::Quality::kFeasible) request_.effort = std::max<std::size_t>(1, request_.effort / kHurry);
  }

  Explanation run() const {
    Explanation explanation;
    explanation.objective = plan_.objective;
    explanation.terms = terms_of(app_, plan_);
    const std::vector<plan::SoftBound> bounds = plan::soft_bounds(app_);
    for (std::size_t b = 0; b < bounds.size(); ++b) explanation.bounds.push_back(cost_of(bounds[b], b));
    explanation.reasons = reasons_of(app_, costs_, instance_, plan_, explanation.bounds);
    for (std::size_t kind = 0; kind < instance_.kinds.size(); ++kind) {
      explanation.one_more.push_back(with_cores(kind, 1));
      std::optional<Variation>& fewer = explanation.one_fewer.emplace_back();
      if (request_.cores > 1 && instance_.kinds[kind].given > 0) fewer = with_cores(kind, -1);
    }
    explanation.runner_up = runner_up_of(app_, costs_, request_, plan_);
    for (std::size_t term = 0; term < app_.objective.size(); ++term) explanation.doubled.push_back(doubled(term));
    return explanation;
  }

 private:
  Variation planned(const graph::App& app, const Request& request) const {
    Result<plan::Plan> plan = make_plan(app, costs_, request);
    if (!plan) return {std::nullopt, plan.error().message()};
    return {*std::move(plan), ""};
  }

  Variation with_cores(std::size_t kind, int more) const {
    Request request = request_;
    request.cores += more;
    return planned(with_more_cores(app_, request_.cores, kind, more), request);
  }

  BoundCost cost_of(const plan::SoftBound& bound, std::size_t index) const {
    BoundCost found;
    found.key = bound.key;
    found.asked = bound.asked;
    found.planned = Millis{value_of(instance_.bounds[index], timings_of(instance_, plan_))};
    found.met = std::abs(found.planned / (bound.asked * plan_.relax_factor) - 1.0) <= kMet;
    found.without = planned(without(app_, bound), request_);
    if (found.without.plan) found.cost = plan_.objective - found.without.plan->objective;
    const bool missed = found.planned > bound.asked * (1.0 + plan::kTolerance);
    found.binds = found.met || missed || found.cost > plan::kTolerance * plan_.objective;
    return found;
  }

  DoubledWeight doubled(std::size_t term) const {
    graph::App other = app_;
    other.objective[term].weight *= 2.0;
    DoubledWeight found;
    found.with = planned(other, request_);
    if (!found.with.plan) return found;
    found.terms = terms_of(app_, *found.with.plan);
    for (std::size_t t = 0; t < found.terms.size(); ++t) {
      found.objective += app_.objective[t].weight * found.terms[t].count();
    }
    found.allocation_changes = allocation_groups(*found.with.plan, app_) != allocation_groups(plan_, app_);
    return found;
  }

  const graph::App& app_;
  const model::CostTable& costs_;
  Request request_;
  const plan::Plan& plan_;
  const Instance instance_;
};

}  // namespace

std::vector<CoreGroup> allocation_groups(const plan::Plan& plan, const graph::App& app) {
  std::vector<CoreGroup> groups;
  std::vector<int> first;  // core of each group
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const std::vector<int>& cores = plan.subchains[i].cores;
    const auto known = std::find(first.begin(), first.end(), cores.front());
    if (known != first.end()) {
      groups[static_cast<std::size_t>(known - first.begin())].subchains.emplace_back(i);
      continue;
    }
    first.push_back(cores.front());
    groups.push_back({{SubchainId(i)}, static_cast<int>(cores.size()), static_cast<int>(app.kind_of(cores.front()))});
  }
  return groups;
}

Explanation explain(const graph::App& app, const model::CostTable& costs, const Request& request,
                    const plan::Plan& plan) {
  return Explaining(app, costs, request, plan).run();
}

}  // namespace ctn::planner
