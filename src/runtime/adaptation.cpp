#include "runtime/adaptation.h"

namespace ctn::runtime {
namespace {

constexpr Nanos kLookAtPower = std::chrono::seconds{1};

}  // namespace

Adaptation::Adaptation(const graph::App& app, os::Os& os, const os::CpuSet& cpus, const policy::CpuKinds& kinds,
                       TimePoint start)
    : os_(os), cpus_(cpus), clock_(start, app.scheduler), power_(kinds, app.kinds()) {}

std::optional<policy::PlanReason> Adaptation::due(TimePoint now, Housekeeper& housekeeper) {
  if (housekeeper.take_cost_change()) clock_.changed(policy::PlanReason::kChange);
  look_at_power(now, housekeeper);
  return clock_.due(now, housekeeper.all_measured());
}

void Adaptation::look_at_power(TimePoint now, Housekeeper& housekeeper) {
  if (now < next_look_) return;
  next_look_ = now + kLookAtPower;
  const std::optional<driver::PowerChange> change = power_.look(os_.power_state(cpus_));
  if (!change) return;
  housekeeper.power_changed(*change);
  clock_.changed(policy::PlanReason::kPower);
}

}  // namespace ctn::runtime
