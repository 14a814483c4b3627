#include "driver/subchain_pacer.h"

#include <algorithm>
#include <utility>

namespace ctn::driver {

TimePoint SubchainPacer::step(TimePoint now) {
  follow(now);
  if (!trigger_) return kNever;
  const std::uint64_t completed = actuator_->completed(subchain_);
  const dispatch::SubchainTrigger::Decision decision = trigger_->step(now, std::min(completed, trigger_->sent()));
  act(decision, now);
  if (decision.ask_on_completion || awaits_) {
    awaits_ = decision.ask_on_completion;
    actuator_->await_completion(subchain_, awaits_, completed);
  }
  return decision.ask_at;
}

void SubchainPacer::follow(TimePoint now) {
  const policy::Assignment& assignment = actuator_->assignment();
  const policy::SubchainPlace& place = assignment.places[subchain_.index()];
  const bool is_new = std::exchange(following_, assignment.number) != assignment.number;
  if (place.core >= 0 || !place.present) {
    if (trigger_) release();
  } else if (trigger_) {
    if (is_new && place != place_) change(now, place);
    if (actuator_->threads_joined()) raise_joined_threads();
  } else if (const std::optional<dispatch::RunState> state = actuator_->take(subchain_)) {
    adopt(now, place, *state);
  }
}

void SubchainPacer::adopt(TimePoint now, const policy::SubchainPlace& place, const dispatch::RunState& state) {
  place_ = place;
  suspended_ = state.hanging;
  actuator_->move(subchain_, place.cpus);
  if (!suspended_) actuator_->set_levels(subchain_, place);
  const TimePoint start = state.sent > 0 ? std::max(now, state.triggered_at + place.pacing.period) : now;
  trigger_.emplace(start, place.pacing, state.sent, state.completed);
}

void SubchainPacer::change(TimePoint now, const policy::SubchainPlace& place) {
  if (place.cpus != place_.cpus) actuator_->move(subchain_, place.cpus);
  const bool same_levels = place.level == place_.level && place.levels == place_.levels;
  if (!same_levels && !suspended_) actuator_->set_levels(subchain_, place);
  if (place.pacing != place_.pacing) trigger_->change_pacing(now, place.pacing);
  place_ = place;
}

void SubchainPacer::raise_joined_threads() {
  actuator_->move(subchain_, place_.cpus);
  if (!suspended_) actuator_->set_levels(subchain_, place_);
}

void SubchainPacer::release() {
  actuator_->set_level(subchain_, os::Level::kOrdinary);
  dispatch::RunState state;
  state.sent = trigger_->sent();
  state.completed = std::min(actuator_->completed(subchain_), state.sent);
  state.triggered_at = trigger_->last_trigger();
  state.hanging = trigger_->hanging();
  trigger_.reset();
  awaits_ = false;
  actuator_->hand_over(subchain_, state);
}

void SubchainPacer::act(const dispatch::SubchainTrigger::Decision& decision, TimePoint now) {
  if (decision.hang_began || decision.hang_ended) {
    suspended_ = decision.hang_began;
    suspended_ ? actuator_->set_level(subchain_, os::Level::kOrdinary) : actuator_->set_levels(subchain_, place_);
    actuator_->hang_changed(subchain_, suspended_, now);
  }
  if (decision.trigger) actuator_->trigger(subchain_, trigger_->sent(), *decision.trigger);
}

}  // namespace ctn::driver
