// "paper": the paper's Catan by name (paper/paper.h), to compare with. Fixed frames; stage II every 5 s, on the cores
// that the plan in force gives each subchain; stage I every 20 s, and whenever a plan is made for another reason than
// that time has passed: the bootstrap is over, a node has run that had not, compute times, power or CPUs have changed.
//
// What is around it is as for `catan`: what counts as a change, how much planning may cost, and that a plan replaces
// the one in force only if that is worth it (replan.h). So are exact rates, which the paper does not have: assumed
// costs are halved, or they are relaxed with the other bounds (docs/decisions/0023).
//
// Units: in the types. Thread safety: as policy.h says.
#pragma once

#include <chrono>
#include <optional>

#include "policy/planned.h"

namespace ctn::policy {

constexpr Nanos kStageTwoEvery = std::chrono::seconds{5};
constexpr int kStageOneEvery = 4;  // of these: 20 s

class PaperPolicy : public PlannedPolicy {
 public:
  PaperPolicy() : PlannedPolicy("paper") {}
  bool adapts() const override { return true; }
  Nanos replan_every(const graph::SchedulerOptions& /*options*/) const override { return kStageTwoEvery; }
  Result<Decision> decide(const Situation& situation) const override;
  Result<std::optional<Decision>> decide_again(const Situation& situation, const Decision& in_force) const override;
};

}  // namespace ctn::policy
