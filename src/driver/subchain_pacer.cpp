#include "driver/subchain_pacer.h"

#include <algorithm>
#include <utility>
#include <variant>

namespace ctn::driver {

namespace {

std::optional<plan::Leader> leader_of(const dispatch::Pacing& pacing) {
  return pacing.after ? std::optional(pacing.after->leader) : std::nullopt;
}

}  // namespace

TimePoint SubchainPacer::step(TimePoint now) {
  follow(now);
  if (!trigger_) return kNever;
  const std::uint64_t completed = actuator_->completed(subchain_);
  const std::uint64_t ended = std::min(completed, trigger_->sent());
  const TimePoint look_at = hear(now);
  if (place_.pacing.clock) {
    if (const std::optional<Ticks> ticks = actuator_->clock(*place_.pacing.clock)) trigger_->align(now, *ticks);
  }
  measure(now, ended);
  const dispatch::SubchainTrigger::Decision decision = trigger_->step(now, ended);
  act(decision, now);
  if (decision.ask_on_completion || awaits_) {
    awaits_ = decision.ask_on_completion;
    actuator_->await_completion(subchain_, awaits_, completed);
  }
  return std::min(decision.ask_at, look_at);
}

void SubchainPacer::follow(TimePoint now) {
  const policy::Assignment& assignment = actuator_->assignment();
  const policy::SubchainPlace& place = assignment.places[subchain_.index()];
  const bool is_new = std::exchange(following_, assignment.number) != assignment.number;
  if (place.core >= 0 || !place.present) {
    if (trigger_) hand_over();
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
  const auto last = state.sent > 0 ? std::optional(state.triggered_at) : std::nullopt;
  trigger_.emplace(dispatch::first_due(place.pacing, now, last), place.pacing, state.sent, state.completed,
                   state.hanging);
  set_leader(leader_of(place.pacing));
  if (place.pacing.budget == Nanos{0} || state.sent == state.completed) return;
  // What a run that is under way used elsewhere does not count.
  actuator_->begin_run(subchain_);
  trigger_->restart_budget(now);
}

void SubchainPacer::change(TimePoint now, const policy::SubchainPlace& place) {
  if (place.cpus != place_.cpus) actuator_->move(subchain_, place.cpus);
  const bool was_demoted = trigger_->demoted();
  if (place.pacing != place_.pacing) {
    if (place_.pacing.budget == Nanos{0} && place.pacing.budget > Nanos{0}) actuator_->begin_run(subchain_);
    trigger_->change_pacing(now, place.pacing);
    set_leader(leader_of(place.pacing));
  }
  const bool same_levels = place.level == place_.level && place.levels == place_.levels;
  const bool restored = was_demoted && !trigger_->demoted();
  if ((!same_levels || restored) && !suspended_ && !trigger_->demoted()) actuator_->set_levels(subchain_, place);
  place_ = place;
}

void SubchainPacer::raise_joined_threads() {
  actuator_->move(subchain_, place_.cpus);
  if (suspended_) return;
  trigger_->demoted() ? actuator_->set_level(subchain_, os::Level::kBackground)
                      : actuator_->set_levels(subchain_, place_);
}

void SubchainPacer::hand_over() {
  set_leader(std::nullopt);
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

void SubchainPacer::set_leader(std::optional<plan::Leader> leader) {
  if (leader == leader_) return;
  if (leader_) actuator_->ignore_outputs(*leader_);
  leader_ = leader;
}

// When to look for outputs, where nothing wakes it.
TimePoint SubchainPacer::hear(TimePoint now) {
  if (!leader_) return kNever;
  const Actuator::Outputs outputs = actuator_->outputs(*leader_);
  const SubchainId* const subchain = std::get_if<SubchainId>(&*leader_);
  const auto runs = subchain != nullptr ? std::optional(actuator_->completed(*subchain)) : std::nullopt;
  trigger_->hear(now, outputs.count, outputs.newest, runs);
  return actuator_->await_outputs(*leader_, trigger_->awaited_outputs()) ? kNever : now + place_.pacing.period;
}

void SubchainPacer::measure(TimePoint now, std::uint64_t completed) {
  if (!trigger_->wants_cpu_time(now, completed)) return;
  cpu_time_ = actuator_->cpu_time(subchain_);
  trigger_->used(now, cpu_time_);
}

void SubchainPacer::act(const dispatch::SubchainTrigger::Decision& decision, TimePoint now) {
  if (decision.demote) {
    actuator_->set_level(subchain_, os::Level::kBackground);
    // Once a run, however often it has a budget again.
    if (std::exchange(told_over_budget_, trigger_->sent()) != trigger_->sent()) {
      actuator_->over_budget({subchain_, trigger_->sent(), now, cpu_time_});
    }
  }
  if (decision.hang_began || decision.hang_ended) {
    suspended_ = decision.hang_began;
    suspended_ ? actuator_->set_level(subchain_, os::Level::kOrdinary) : actuator_->set_levels(subchain_, place_);
    actuator_->hang_changed(subchain_, suspended_, now);
  }
  if (decision.restore && !suspended_) actuator_->set_levels(subchain_, place_);
  if (!decision.trigger) return;
  if (place_.pacing.budget > Nanos{0}) actuator_->begin_run(subchain_);
  actuator_->trigger(subchain_, trigger_->sent(), *decision.trigger);
}

}  // namespace ctn::driver
