#include "policy/planned.h"

#include <algorithm>
#include <cmath>

#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/validate.h"
#include "planner/formulas.h"
#include "policy/levels.h"

namespace ctn::policy {
namespace {

// How often assumed costs are halved at most. A guess that is 256 times too high is not what stands in the way.
constexpr int kMaxHalvings = 8;

model::CostTable with_assumed(model::CostTable costs, std::span<const NodeId> assumed, double factor) {
  for (const NodeId node : assumed) costs.set(node, costs[node].times(factor));
  return costs;
}

Decision expecting(plan::Plan plan, const Situation& situation) {
  say_what_is_known(plan, situation.costs, situation.assumed, situation.app.graph);
  plan.expected = plan::expect(plan, plan::as_planned(situation.app, plan), situation.typical);
  return PlannedPolicy::following(std::move(plan), situation);
}

}  // namespace

void say_what_is_known(plan::Plan& plan, const model::CostTable& costs, std::span<const NodeId> assumed,
                       const graph::Graph& graph) {
  plan.assumed.clear();
  for (const NodeId node : assumed) plan.assumed.push_back({node, costs[node].single_thread()});
  plan.outputs.clear();
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const double runs = costs.runs_per_output(NodeId(index));
    if (runs > 1.0) plan.outputs.push_back({NodeId(index), runs});
  }
}

Result<Decision> decide_in_any_case(const Situation& situation, const MakePlan& make) {
  Result<plan::Plan> plan = make(situation.app, situation.costs, false);
  if (plan) return expecting(std::move(*plan), situation);
  if (!plan::has_exact_rates(situation.app.graph)) return plan.error();
  for (int halvings = 1; halvings <= kMaxHalvings && !situation.assumed.empty(); ++halvings) {
    const double factor = std::ldexp(1.0, -halvings);
    const model::CostTable costs = with_assumed(situation.costs, situation.assumed, factor);
    Result<plan::Plan> lower = make(situation.app, costs, true);
    if (!lower) continue;
    const model::CostTable typical = with_assumed(situation.typical, situation.assumed, factor);
    return expecting(std::move(*lower), {.app = situation.app,
                                         .cpus = situation.cpus,
                                         .costs = costs,
                                         .typical = typical,
                                         .slack = situation.slack,
                                         .stealing = situation.stealing,
                                         .frames = situation.frames,
                                         .assumed = situation.assumed});
  }
  Result<plan::Plan> relaxed = make(plan::relaxing_exact_rates(situation.app), situation.costs, false);
  if (!relaxed) return plan.error();
  return expecting(std::move(*relaxed), situation);
}

Decision PlannedPolicy::following(plan::Plan plan, const Situation& situation) {
  Decision decision;
  const graph::App app = plan::as_planned(situation.app, plan);
  decision.assignment = assignment_of(app, plan, situation.cpus, {.stealing = situation.stealing});
  decision.plan = std::move(plan);
  rise_above_assigned(decision);
  return decision;
}

Decision rates_only(const Decision& in_force, const os::CpuSet& cpus) {
  Decision decision = in_force;
  decision.plan.reset();
  decision.assignment = {};
  decision.assignment.cores.resize(cpus.size());
  for (std::size_t index = 0; index < in_force.assignment.places.size(); ++index) {
    const SubchainPlace& before = in_force.assignment.places[index];
    SubchainPlace& place = decision.assignment.places.emplace_back();
    place.cpus = cpus;
    place.threads = before.threads;
    // Never before the last run has ended: there are fewer CPUs than the periods were made for.
    place.pacing.max_in_flight = 1;
    place.pacing.period = in_force.plan
                              ? std::max(dispatch::kShortestPeriod,
                                         to_nanos(plan::usual_timing(*in_force.plan, SubchainId(index)).period))
                              : before.pacing.period;
  }
  return decision;
}

Result<Decision> FormulaPolicy::decide(const Situation& situation) const {
  return decide_in_any_case(situation, [&](const graph::App& app, const model::CostTable& costs, bool) {
    return planner::make_plan_by_formulas(
        app, costs, {.cores = static_cast<int>(situation.cpus.size()), .slack = situation.slack, .count_cores = false});
  });
}

Result<Decision> StaticPolicy::decide(const Situation& situation) const {
  const graph::App app = plan::as_planned(situation.app, plan_);
  plan::Plan plan = plan_;
  const auto is_exact = [&](const plan::Slot& slot) {
    return plan::period_limits(app.graph, slot.subchain).exact.has_value();
  };
  for (plan::CorePlan& core : plan.cores) {
    // Where a rate is exact, frames are fixed whatever is asked.
    if (situation.frames && std::none_of(core.slots.begin(), core.slots.end(), is_exact)) {
      core.frames = *situation.frames;
    }
  }
  if (Status valid = plan::validate_layout(plan, app, static_cast<int>(situation.cpus.size())); !valid) {
    return valid.error();
  }
  return following(std::move(plan), situation);
}

}  // namespace ctn::policy
