// Catan's policy that plans by what schedules come to in virtual time (planner/schedule_search.h), while the app runs:
// a first plan by formulas within milliseconds of CPU time, then a little better with every step of the planning loop,
// as the budget allows (planning_budget.h).
//
// How a decision is made:
//   1. When costs have changed by more than noise since the search was last given them, it is given new ones, drawn
//      from the runs that were measured. What it has found stays.
//   2. When something has happened (the first measurements, a lasting change, other CPUs), it guesses anew, and a plan
//      in frames (planner/frames.h) is put beside, unless the app file says `schedule: priorities`.
//   3. The search goes on for one step of the loop: kSearchStep.
//   4. The best schedule replaces the one in force where that cannot go on, or if trials find it better by more than
//      kBetter. Else the plan in force goes on; once costs have changed, with promises and budgets that fit them.
//
// Where an exact rate cannot be met, or the app file says `schedule: frames`, formulas alone decide (planned.h).
//
// Units: in the types. Thread safety: as policy.h says; a Memory has one owner.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "policy/planned.h"
#include "policy/policy.h"

namespace ctn::policy {

class SearchPolicy : public PlannedPolicy {
 public:
  explicit SearchPolicy(std::string name = "auto") : PlannedPolicy(std::move(name)) {}
  bool adapts() const override { return true; }
  bool judges() const override { return true; }
  std::unique_ptr<Memory> make_memory() const override;
  // By formulas: nothing has run, and what nodes cost is only assumed.
  Result<Decision> decide(const Situation& situation) const override { return formulas_.decide(situation); }
  // None: what is in force goes on as it is. Precondition: situation.memory is of make_memory(), or null.
  Result<std::optional<Decision>> decide_again(const Situation& situation, const Decision& in_force) const override;

 private:
  FormulaPolicy formulas_;
};

}  // namespace ctn::policy
