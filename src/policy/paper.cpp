#include "policy/paper.h"

#include <cmath>
#include <utility>

#include "paper/paper.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::policy {
namespace {

// Of each stage while an app runs: some tens of milliseconds at most for an app of a few subchains.
constexpr std::size_t kSteps = 300'000;

// How often assumed costs are halved at most (planned.cpp).
constexpr int kMostHalvings = 8;

model::CostTable lowered(model::CostTable costs, std::span<const NodeId> assumed, double factor) {
  for (const NodeId node : assumed) costs.set(node, costs[node].times(factor));
  return costs;
}

class Planning {
 public:
  // `allocated`: whose cores are kept, by stage II alone; may be null.
  Planning(const Situation& situation, const plan::Plan* allocated)
      : situation_(situation), app_(paper::as_in_the_paper(situation.app)), allocated_(allocated) {}

  Result<Decision> run() const {
    Result<plan::Plan> plan = plan_at(app_, situation_.costs);
    if (plan) return decision(std::move(*plan), 1.0);
    if (!plan::has_exact_rates(app_.graph)) return plan.error();
    for (int halvings = 1; halvings <= kMostHalvings && !situation_.assumed.empty(); ++halvings) {
      const double factor = std::ldexp(1.0, -halvings);
      Result<plan::Plan> lower = plan_at(app_, lowered(situation_.costs, situation_.assumed, factor));
      if (lower) return decision(std::move(*lower), factor);
    }
    Result<plan::Plan> relaxed = plan_at(plan::relaxing_exact_rates(app_), situation_.costs);
    if (!relaxed) return plan.error();
    return decision(std::move(*relaxed), 1.0);
  }

 private:
  // Where exact rates do not fit the cores that are kept, others may do.
  Result<plan::Plan> plan_at(const graph::App& app, const model::CostTable& costs) const {
    paper::Request request{.cores = static_cast<int>(situation_.cpus.size()),
                           .slack = situation_.slack,
                           .steps = kSteps,
                           .allocated = allocated_};
    Result<plan::Plan> plan = paper::make_plan(app, costs, request);
    if (plan || !request.allocated) return plan;
    request.allocated = nullptr;
    return paper::make_plan(app, costs, request);
  }

  // `factor`: by which assumed costs were lowered.
  Decision decision(plan::Plan plan, double factor) const {
    const model::CostTable costs = lowered(situation_.costs, situation_.assumed, factor);
    const model::CostTable typical = lowered(situation_.typical, situation_.assumed, factor);
    for (const NodeId node : situation_.assumed) plan.assumed.push_back({node, costs[node].single_thread()});
    plan.expected = plan::expect(plan, plan::as_planned(app_, plan), typical);
    return PlannedPolicy::following(std::move(plan), {.app = app_,
                                                      .cpus = situation_.cpus,
                                                      .costs = costs,
                                                      .typical = typical,
                                                      .slack = situation_.slack,
                                                      .stealing = situation_.stealing});
  }

  const Situation& situation_;
  const graph::App app_;
  const plan::Plan* const allocated_;
};

}  // namespace

Result<Decision> PaperPolicy::decide(const Situation& situation) const { return Planning(situation, nullptr).run(); }

Result<std::optional<Decision>> PaperPolicy::decide_again(const Situation& situation, const Decision& in_force,
                                                          double /*to_beat*/) const {
  const bool keeps_cores =
      situation.periodic % kStageOneEvery != 0 && in_force.plan && in_force.plan->cores.size() == situation.cpus.size();
  Result<Decision> decision = Planning(situation, keeps_cores ? &*in_force.plan : nullptr).run();
  if (!decision) return decision.error();
  return std::optional(std::move(*decision));
}

}  // namespace ctn::policy
