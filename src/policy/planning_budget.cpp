#include "policy/planning_budget.h"

#include <algorithm>
#include <cassert>

namespace ctn::policy {

Nanos PlanningBudget::owed(TimePoint now) const {
  const double repaid = share() * static_cast<double>((now - since_).count());
  return std::max(owed_ - Nanos{static_cast<Nanos::rep>(repaid)}, -saved_);
}

bool PlanningBudget::allows(TimePoint now, Urgency urgency) const {
  return owed(now) <= (urgency == Urgency::kChange ? last_ : Nanos{0});
}

void PlanningBudget::spend(TimePoint now, Nanos cpu) {
  assert(now >= since_ && cpu >= Nanos{0});
  owed_ = owed(now) + cpu;
  since_ = now;
  last_ = cpu;
  spent_ += cpu;
  ++plans_;
}

}  // namespace ctn::policy
