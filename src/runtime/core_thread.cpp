#include "runtime/core_thread.h"

#include <algorithm>

#include "policy/levels.h"

namespace ctn::runtime {

CoreThread::CoreThread(Controls& controls, const std::vector<SubchainLinks>& subchains, int core)
    : Controller(controls, subchains, controls.number_of_core(core), core),
      controls_(controls),
      core_(core),
      level_(subchains.size()) {}

void CoreThread::run() {
  dispatch::SharedCoreDispatcher dispatcher(now(), {});
  while (!stopping()) {
    const std::uint32_t seen = attention_now();
    follow(dispatcher);
    gather_progress(dispatcher);
    const TimePoint at = now();
    const dispatch::SharedCoreDispatcher::Decision& decision = dispatcher.step(at, progress_);
    carry_out(decision);
    report(decision, at);
    sleep(seen, decision.ask_at, !wait_for_completion_of(decision.wake_on_completion));
  }
}

void CoreThread::follow(dispatch::SharedCoreDispatcher& dispatcher) {
  const Assignment& assignment = look();
  if (assignment.number != following_) {
    following_ = assignment.number;
    dispatcher.change_schedule(assignment.cores[static_cast<std::size_t>(core_)]);
  }
  adopt_waiting(dispatcher, assignment);
  raise_newcomers();
}

void CoreThread::adopt_waiting(dispatch::SharedCoreDispatcher& dispatcher, const Assignment& assignment) {
  for (const dispatch::SharedCoreSlot& slot : assignment.cores[static_cast<std::size_t>(core_)].slots) {
    const std::size_t index = slot.subchain.index();
    if (level_[index]) continue;
    const std::optional<dispatch::RunState> state = controls_.handovers[index].take();
    if (!state) continue;
    hold(slot.subchain, assignment.places[index].cpus);
    set_level(slot.subchain, os::Level::kOrdinary);
    level_[index] = os::Level::kOrdinary;
    dispatcher.adopt(slot.subchain, *state);
  }
}

// Threads that joined a node come at the ordinary level.
void CoreThread::raise_newcomers() {
  for (std::size_t index = 0; index < level_.size(); ++index) {
    const SubchainId id(index);
    if (!level_[index] || !threads_joined(id)) continue;
    move_threads(id, look().places[index].cpus);
    set_level(id, *level_[index]);
  }
}

void CoreThread::gather_progress(const dispatch::SharedCoreDispatcher& dispatcher) {
  slots_.clear();
  progress_.clear();
  for (const dispatch::SharedCoreSlot& slot : dispatcher.schedule().slots) {
    slots_.push_back(slot.subchain);
    progress_.push_back(completed(slot.subchain));
  }
}

void CoreThread::carry_out(const dispatch::SharedCoreDispatcher::Decision& decision) {
  for (const auto& [subchain, level] : decision.levels) {
    level_[subchain.index()] = policy::to_os(level);
    set_level(subchain, policy::to_os(level));
  }
  for (const auto& [subchain, number, due] : decision.triggers) trigger(subchain, number, due);
  for (const auto& [subchain, state] : decision.released) {
    level_[subchain.index()].reset();
    if (awaited_ == subchain) awaited_.reset();
    hand_over(subchain, state);
  }
}

void CoreThread::report(const dispatch::SharedCoreDispatcher::Decision& decision, TimePoint at) {
  for (const auto& slot : decision.slots) report_slot(slot.subchain, slot.planned, slot.begin, slot.end);
  for (const auto& steal : decision.steals) {
    if (steal.end) report_steal(steal.thief, steal.victim, steal.begin, *steal.end);
  }
  for (const auto& hang : decision.hangs) report_hang(hang.subchain, hang.began, at);
}

bool CoreThread::wait_for_completion_of(std::optional<SubchainId> subchain) {
  if (awaited_ && awaited_ != subchain) want_completions(*awaited_, false);
  awaited_ = subchain;
  if (!subchain) return true;
  want_completions(*subchain, true);
  const auto slot = std::find(slots_.begin(), slots_.end(), *subchain);
  if (slot == slots_.end()) return true;
  return completed(*subchain) == progress_[static_cast<std::size_t>(slot - slots_.begin())];
}

}  // namespace ctn::runtime
