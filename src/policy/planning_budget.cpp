#include "policy/planning_budget.h"

#include <algorithm>
#include <cassert>

namespace ctn::policy {

Nanos PlanningBudget::owed(TimePoint now) const {
  const double repaid = share() * static_cast<double>((now - since_).count());
  return std::max(owed_ - Nanos{static_cast<Nanos::rep>(repaid)}, -saved_);
}

bool PlanningBudget::allows(TimePoint now, Urgency urgency) const {
  switch (urgency) {
    case Urgency::kRoutine:
      return owed(now) <= Nanos{0};
    case Urgency::kChange:
      return owed(now) <= last_;
    case Urgency::kEmergency:
      return true;
  }
  return true;
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
