#include "driver/core_driver.h"

#include <algorithm>
#include <utility>

#include "policy/levels.h"

namespace ctn::driver {

CoreDriver::CoreDriver(Actuator& actuator, int core, std::size_t subchains)
    : actuator_(&actuator), core_(core), dispatcher_(TimePoint{}, {}, core), held_(subchains) {}

TimePoint CoreDriver::step(TimePoint now) {
  follow();
  collect_progress();
  const dispatch::SharedCoreDispatcher::Decision& decision = dispatcher_.step(now, progress_);
  carry_out(decision);
  report(decision, now);
  await_completion_of(decision.wake_on_completion);
  return decision.ask_at;
}

void CoreDriver::follow() {
  const policy::Assignment& assignment = actuator_->assignment();
  if (std::exchange(following_, assignment.number) != assignment.number) {
    const dispatch::SharedCoreSchedule& schedule = assignment.cores[static_cast<std::size_t>(core_)];
    dispatcher_.change_schedule(schedule);
    find_absent(schedule);
  }
  if (!absent_.empty()) adopt_waiting(assignment);
  if (actuator_->threads_joined()) raise_joined_threads();
}

void CoreDriver::find_absent(const dispatch::SharedCoreSchedule& schedule) {
  absent_.clear();
  for (const dispatch::SharedCoreSlot& slot : schedule.slots) {
    if (!held_[slot.subchain.index()]) absent_.push_back(slot.subchain);
  }
}

void CoreDriver::adopt_waiting(const policy::Assignment& assignment) {
  std::erase_if(absent_, [&](SubchainId subchain) {
    const std::optional<dispatch::RunState> state = actuator_->take(subchain);
    if (!state) return false;
    const os::CpuSet& cpus = assignment.places[subchain.index()].cpus;
    actuator_->move(subchain, cpus);
    actuator_->set_level(subchain, os::Level::kOrdinary);
    held_[subchain.index()] = Held{os::Level::kOrdinary, cpus};
    dispatcher_.adopt(subchain, *state);
    return true;
  });
}

void CoreDriver::raise_joined_threads() {
  for (std::size_t index = 0; index < held_.size(); ++index) {
    if (!held_[index]) continue;
    actuator_->move(SubchainId(index), held_[index]->cpus);
    actuator_->set_level(SubchainId(index), held_[index]->level);
  }
}

void CoreDriver::collect_progress() {
  progress_.clear();
  for (const SubchainId subchain : members_) progress_.push_back(actuator_->completed(subchain));
}

void CoreDriver::carry_out(const dispatch::SharedCoreDispatcher::Decision& decision) {
  for (const auto& [subchain, level] : decision.levels) {
    held_[subchain.index()]->level = policy::to_os(level);
    actuator_->set_level(subchain, policy::to_os(level));
  }
  for (const auto& [subchain, number, due] : decision.triggers) actuator_->trigger(subchain, number, due);
  for (const auto& [subchain, state] : decision.handed_over) hand_over(subchain, state);
  if (!decision.swapped) return;
  members_.clear();
  for (const dispatch::SharedCoreSlot& slot : dispatcher_.schedule().slots) members_.push_back(slot.subchain);
}

void CoreDriver::hand_over(SubchainId subchain, const dispatch::RunState& state) {
  held_[subchain.index()].reset();
  if (awaited_ == subchain) awaited_.reset();
  actuator_->hand_over(subchain, state);
}

void CoreDriver::report(const dispatch::SharedCoreDispatcher::Decision& decision, TimePoint now) {
  for (const dispatch::SlotUse& slot : decision.slots) actuator_->slot_over(slot);
  for (const dispatch::Steal& steal : decision.steals) actuator_->stole(steal);
  for (const auto& hang : decision.hangs) actuator_->hang_changed(hang.subchain, hang.began, now);
}

void CoreDriver::await_completion_of(std::optional<SubchainId> subchain) {
  if (awaited_ && awaited_ != subchain) actuator_->await_completion(*awaited_, false, 0);
  awaited_ = subchain;
  if (!subchain) return;
  const auto member = std::find(members_.begin(), members_.end(), *subchain);
  if (member == members_.end()) return;
  actuator_->await_completion(*subchain, true, progress_[static_cast<std::size_t>(member - members_.begin())]);
}

}  // namespace ctn::driver
