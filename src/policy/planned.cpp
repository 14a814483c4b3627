#include "policy/planned.h"

#include <algorithm>
#include <cmath>

#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/validate.h"
#include "planner/planner.h"
#include "policy/levels.h"

namespace ctn::policy {
namespace {

// The planner's effort once there is a plan: what it costs is CPU time of the same machine, and of the budget.
constexpr std::size_t kReplanEffort = 100'000;

planner::Request request_of(const Situation& situation) {
  return {.cores = static_cast<int>(situation.cpus.size()), .slack = situation.slack};
}

Decision expecting(plan::Plan plan, const Situation& situation) {
  plan.expected = plan::expect(plan, situation.app, situation.typical);
  return PlannedPolicy::following(std::move(plan), situation);
}

}  // namespace

Decision PlannedPolicy::following(plan::Plan plan, const Situation& situation) {
  Decision decision;
  decision.assignment = assignment_of(situation.app, plan, situation.cpus, {.stealing = situation.stealing});
  decision.plan = std::move(plan);
  rise_above_assigned(decision);
  return decision;
}

Result<Decision> CatanPolicy::decide(const Situation& situation) const {
  Result<plan::Plan> plan = planner::make_plan(situation.app, situation.costs, request_of(situation));
  if (!plan) return plan.error();
  return expecting(std::move(*plan), situation);
}

Result<std::optional<Decision>> CatanPolicy::decide_again(const Situation& situation, const Decision& in_force,
                                                          double to_beat) const {
  planner::Request request = request_of(situation);
  request.effort = kReplanEffort;
  request.warm = in_force.plan ? &*in_force.plan : nullptr;
  if (!std::isfinite(to_beat)) {
    Result<plan::Plan> plan = planner::make_plan(situation.app, situation.costs, request);
    if (!plan) return plan.error();
    return std::optional(expecting(std::move(*plan), situation));
  }
  Result<std::optional<plan::Plan>> better = planner::make_plan_below(situation.app, situation.costs, request, to_beat);
  if (!better) return better.error();
  if (!*better) return std::optional<Decision>();
  return std::optional(expecting(std::move(**better), situation));
}

Result<Decision> StaticPolicy::decide(const Situation& situation) const {
  const graph::App& app = situation.app;
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
