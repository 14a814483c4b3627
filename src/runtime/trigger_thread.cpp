#include "runtime/trigger_thread.h"

#include <algorithm>

namespace ctn::runtime {

TriggerThread::TriggerThread(Controls& controls, const std::vector<SubchainLinks>& subchains, SubchainId subchain)
    : Controller(controls, subchains, subchain.index(), -1), controls_(controls), subchain_(subchain) {}

void TriggerThread::run() {
  while (!stopping()) {
    const std::uint32_t seen = attention_now();
    follow();
    if (!trigger_) {
      sleep(seen, kNever);
      continue;
    }
    const std::uint64_t done = completed(subchain_);
    const TimePoint at = now();
    const dispatch::SubchainTrigger::Decision decision = trigger_->step(at, std::min(done, trigger_->sent()));
    act(decision, at);
    want_completions(subchain_, decision.ask_on_completion);
    sleep(seen, decision.ask_at, decision.ask_on_completion && completed(subchain_) != done);
  }
}

void TriggerThread::follow() {
  const Assignment& assignment = look();
  const policy::SubchainPlace& place = assignment.places[subchain_.index()];
  const bool is_new = assignment.number != following_;
  following_ = assignment.number;
  if (place.core >= 0 || !place.present) {
    if (trigger_) give_up();
  } else if (trigger_) {
    if (is_new && place != place_) change(place);
    if (threads_joined(subchain_)) {
      move_threads(subchain_, place_.cpus);
      if (!contained_) set_levels(subchain_, place_);
    }
  } else if (const std::optional<dispatch::RunState> state = controls_.handovers[subchain_.index()].take()) {
    begin(place, *state);
  }
}

void TriggerThread::begin(const policy::SubchainPlace& place, const dispatch::RunState& state) {
  place_ = place;
  contained_ = state.hanging;
  hold(subchain_, place.cpus);
  if (!contained_) set_levels(subchain_, place);
  TimePoint start = now();
  if (state.sent > 0) start = std::max(start, state.triggered_at + place.pacing.period);
  trigger_.emplace(start, place.pacing, state.sent, state.completed);
}

void TriggerThread::change(const policy::SubchainPlace& place) {
  if (place.cpus != place_.cpus) move_threads(subchain_, place.cpus);
  const bool same_levels = place.level == place_.level && place.levels == place_.levels;
  if (!same_levels && !contained_) set_levels(subchain_, place);
  if (place.pacing != place_.pacing) trigger_->change_pacing(now(), place.pacing);
  place_ = place;
}

void TriggerThread::give_up() {
  set_level(subchain_, os::Level::kOrdinary);
  dispatch::RunState state;
  state.sent = trigger_->sent();
  state.completed = std::min(completed(subchain_), state.sent);
  state.triggered_at = trigger_->last_trigger();
  state.hanging = trigger_->hanging();
  trigger_.reset();
  hand_over(subchain_, state);
}

void TriggerThread::act(const dispatch::SubchainTrigger::Decision& decision, TimePoint at) {
  if (decision.hang_began || decision.hang_ended) {
    contained_ = decision.hang_began;
    contained_ ? set_level(subchain_, os::Level::kOrdinary) : set_levels(subchain_, place_);
    report_hang(subchain_, contained_, at);
  }
  if (decision.trigger) trigger(subchain_, trigger_->sent(), *decision.trigger);
}

}  // namespace ctn::runtime
