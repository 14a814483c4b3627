// How much CPU time planning anew may use: at most half a percent of a core in the long run, so that adapting to costs
// never costs what it saves. Pure.
//
// What a plan cost is owed, and paid back at that rate. While anything is owed nothing is planned for the sake of the
// clock; a lasting change may be answered while no more than the plan before it is owed. So over any time T such plans
// use at most kPlanningShare x T and two plans more: one of each sort. What cannot wait (the first plan from measured
// times, a CPU that went) is made at any rate, and paid back afterwards.
//
// Units: CPU time of the planning thread. Thread safety: none; one owner.
#pragma once

#include <cstdint>

#include "base/time.h"

namespace ctn::policy {

// Of one core.
constexpr double kPlanningShare = 0.005;

class PlanningBudget {
 public:
  enum class Urgency { kRoutine, kChange, kEmergency };

  bool allows(TimePoint now, Urgency urgency) const;
  // A plan was made, or failed, and took that much. Precondition: calls come in the order of time.
  void spend(TimePoint now, Nanos cpu);

  Nanos spent() const { return spent_; }
  std::uint64_t plans() const { return plans_; }

 private:
  Nanos owed(TimePoint now) const;

  Nanos owed_{0};  // as of since_
  TimePoint since_{};
  Nanos last_{0};
  Nanos spent_{0};
  std::uint64_t plans_ = 0;
};

}  // namespace ctn::policy
