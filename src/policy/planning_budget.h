// How much CPU time re-planning may use: at most half a percent of a core in the long run, so that adapting to costs
// never costs what it saves. Pure.
//
// The CPU time of a plan is a debt, which is paid back at that rate. While there is any debt, no periodic plan is made;
// a lasting change may be answered while the debt is no more than the cost of the plan before it. So over any time T
// such plans use at most kPlanningShare x T and two plans more: one of each sort. What cannot wait (the first plan from
// measured times, a CPU that went) is made at any rate, and paid back afterwards.
//
// Units: CPU time of the planning thread. Thread safety: none; one owner.
#pragma once

#include <cstdint>

#include "base/time.h"

namespace ctn::policy {

// Of one core.
constexpr double kPlanningShare = 0.005;

// A search that goes on in small steps (policy.h, Memory) has more use of its time at the beginning: it may save up
// half of a minute's, which it has from the start, and repays at half the rate. That makes no more in any minute.
constexpr Nanos kSavedForSearch = std::chrono::milliseconds{150};

class PlanningBudget {
 public:
  // `saved`: so much may be used at once, once it was not used for long enough; and at the beginning.
  explicit PlanningBudget(Nanos saved = Nanos{0}) : saved_(saved), owed_(-saved) {}

  enum class Urgency { kRoutine, kChange };

  bool allows(TimePoint now, Urgency urgency) const;
  // A plan was made, or failed, and took that much. Precondition: calls come in the order of time.
  void spend(TimePoint now, Nanos cpu);

  Nanos spent() const { return spent_; }
  std::uint64_t plans() const { return plans_; }

 private:
  Nanos owed(TimePoint now) const;
  double share() const { return saved_ > Nanos{0} ? kPlanningShare / 2.0 : kPlanningShare; }

  Nanos saved_;
  Nanos owed_;  // as of since_; less than 0: saved
  TimePoint since_{};
  Nanos last_{0};
  Nanos spent_{0};
  std::uint64_t plans_ = 0;
};

}  // namespace ctn::policy
