
#include "trial/machine.h"

namespace ctn::trial {

void Machine::start_frames() {
  frames_.resize(static_cast<std::size_t>(schedule_.cores));
  for (std::size_t core = 0; core < schedule_.frames.size(); ++core) {
    const dispatch::SharedCoreSchedule& schedule = schedule_.frames[core];
    if (schedule.slots.empty()) continue;
    frames_[core] = Frames{dispatch::SharedCoreDispatcher(TimePoint{}, schedule, static_cast<int>(core)), {}, {}, 0};
    Frames& frames = *frames_[core];
    for (const dispatch::SharedCoreSlot& slot : schedule.slots) frames.dispatcher.adopt(slot.subchain, {});
    step_frames(static_cast<int>(core), WokenBy::kEvent);
  }
}

// The dispatcher looks, and what it decides is carried out.
void Machine::step_frames(int core, WokenBy by) {
  Frames& frames = *frames_[static_cast<std::size_t>(core)];
  hold(core, by);
  frames.progress.clear();
  for (const dispatch::SharedCoreSlot& slot : frames.dispatcher.schedule().slots) {
    frames.progress.push_back(subchains_[slot.subchain.index()].completed);
  }
  const dispatch::SharedCoreDispatcher::Decision& decision = frames.dispatcher.step(now_, frames.progress);
  for (const auto& [id, level] : decision.levels) {
    Subchain& subchain = subchains_[id.index()];
    subchain.rank = rank_of(level);
    if (under_way(subchain)) set_rank(static_cast<Job>(id.index()), subchain.rank);
  }
  for (const auto& triggered : decision.triggers) begin_first_node(subchains_[triggered.subchain.index()]);
  frames.awaited = decision.wake_on_completion;
  const Timers::Source source = source_of_frames(core);
  if (decision.ask_at == kNever) {
    timers_.set(source, kNever);
  } else {
    set_timer(source, decision.ask_at, frames.timers_set);
  }
  touch(core);
}

}  // namespace ctn::trial
