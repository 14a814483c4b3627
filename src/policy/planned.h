// Policies that follow a plan: one that formulas make in some milliseconds, again as costs change, and one that is
// given.
//
// Units: in the types. Thread safety: as policy.h says.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "policy/policy.h"

namespace ctn::policy {

class PlannedPolicy : public Policy {
 public:
  bool follows_plan() const override { return true; }
  bool raises() const override { return true; }

  // What it means to follow a plan that is valid for the situation.
  static Decision following(plan::Plan plan, const Situation& situation);

 protected:
  using Policy::Policy;
};

// Puts into the plan what is known of the runs that it was made for: whose costs are `assumed`, and which nodes give
// fewer outputs than they have runs.
void say_what_is_known(plan::Plan& plan, const model::CostTable& costs, std::span<const NodeId> assumed,
                       const graph::Graph& graph);

// In place of a plan, where none can be made: subchains at the periods of `in_force`, as ordinary threads on all
// `cpus`.
Decision rates_only(const Decision& in_force, const os::CpuSet& cpus);

// An app runs even where its exact rates cannot be met. Costs that are only assumed are no reason to give up a rate:
// they are halved until there is a plan, a few times at most. Where that does not help, exact rates are relaxed with
// the other bounds (plan/limits.h). The plan says both, and what it is expected to give at typical costs. Errors: of
// the first attempt.
//
// `make`: plans for an app of the situation's graph, at costs that may be lowered for what is only assumed.
using MakePlan =
    std::function<Result<plan::Plan>(const graph::App& app, const model::CostTable& costs, bool costs_are_lowered)>;
Result<Decision> decide_in_any_case(const Situation& situation, const MakePlan& make);

// What formulas alone make (planner/formulas.h), in any case: in frames, unless the app file says otherwise or there is
// no such plan. `Plan::solve_time` is left 0, for a caller that has a clock.
class FormulaPolicy : public PlannedPolicy {
 public:
  explicit FormulaPolicy(std::string name = "formulas") : PlannedPolicy(std::move(name)) {}
  bool adapts() const override { return true; }
  Result<Decision> decide(const Situation& situation) const override;
};

// A plan that is given is taken at its word: at which compute times it was made is not known. Its slack counts, not the
// situation's.
class StaticPolicy : public PlannedPolicy {
 public:
  // `plan` is of the situation's app, which is checked when it is decided upon.
  StaticPolicy(std::string name, plan::Plan plan) : PlannedPolicy(std::move(name)), plan_(std::move(plan)) {}
  Result<Decision> decide(const Situation& situation) const override;

 private:
  plan::Plan plan_;
};

}  // namespace ctn::policy
