#include "policy/assignment.h"

#include <utility>

#include "policy/replan.h"

namespace ctn::policy {
namespace {

SubchainPlace place_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus, SubchainId id) {
  const plan::SubchainPlan& planned = plan.subchains[id.index()];
  SubchainPlace place;
  place.threads = planned.threads;
  std::vector<int> numbers;
  for (const int core : planned.cores) numbers.push_back(cpus.cpus()[static_cast<std::size_t>(core)]);
  place.cpus = os::CpuSet(std::move(numbers));
  if (plan::shares_core(plan, planned)) {
    place.core = planned.cores.front();
  } else {
    place.pacing = pacing_of(app, plan, id);
    place.level = os::Level::kActive;
  }
  return place;
}

}  // namespace

Assignment assignment_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus,
                         const AssignmentOptions& options) {
  Assignment assignment;
  for (std::size_t index = 0; index < plan.subchains.size(); ++index) {
    assignment.places.push_back(place_of(app, plan, cpus, SubchainId(index)));
  }
  const dispatch::ScheduleOptions schedule{
      .stealing = options.stealing, .hang_multiple = kHangMultiple, .shortest_hang = kShortestHang};
  for (std::size_t core = 0; core < plan.cores.size(); ++core) {
    assignment.cores.push_back(dispatch::shared_core_schedule(app, plan, static_cast<int>(core), schedule));
  }
  return assignment;
}

void remove_absent(Assignment& assignment, const std::vector<bool>& present) {
  for (std::size_t index = 0; index < present.size(); ++index) assignment.places[index].present = present[index];
  for (dispatch::SharedCoreSchedule& core : assignment.cores) {
    std::erase_if(core.slots, [&](const dispatch::SharedCoreSlot& slot) { return !present[slot.subchain.index()]; });
  }
}

}  // namespace ctn::policy
