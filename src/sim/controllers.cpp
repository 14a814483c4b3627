#include "sim/controllers.h"

#include <algorithm>
#include <utility>

#include "policy/levels.h"

namespace ctn::sim {

Controllers::Controllers(const graph::App& app, const Machine& machine, int cores, Nodes& nodes, Cpus& cpus,
                         Cpus::Thread first, Journal& journal)
    : costs_(machine.costs),
      nodes_(nodes),
      cpus_(cpus),
      first_(first),
      journal_(journal),
      cores_(static_cast<std::size_t>(cores)),
      real_time_(machine.real_time) {
  const std::size_t subchains = app.graph.subchains().size();
  for (std::size_t index = 0; index < subchains; ++index) pacers_.emplace_back().subchain = SubchainId(index);
  for (std::size_t core = 0; core < cores_.size(); ++core) cores_[core].number = static_cast<int>(core);
  sleeping_.resize(pacers_.size() + cores_.size());
  handed_over_.assign(subchains, dispatch::RunState{});
}

void Controllers::start(policy::Assignment assignment, const os::CpuSet& cpus, os::Level level,
                        const std::vector<Nanos>& first) {
  take_over(std::move(assignment));
  for (std::size_t controller = 0; controller < count(); ++controller) {
    const Cpus::Thread thread = first_ + static_cast<Cpus::Thread>(controller);
    const bool bound = controller >= pacers_.size();
    cpus_.set_cpus(thread, bound ? CpuMask::only(cpus.cpus()[controller - pacers_.size()]) : CpuMask(cpus));
    cpus_.set_level(thread, real_time_ ? static_cast<Cpus::Level>(level) : 0);
    const Nanos begin = first_of(controller, first);
    begin > Nanos{0} ? cpus_.wake_at(thread, cpus_.now() + begin) : nudge(controller, -1);
  }
}

Nanos Controllers::first_of(std::size_t controller, const std::vector<Nanos>& first) const {
  if (first.empty()) return Nanos{0};
  if (controller < pacers_.size()) return first[controller];
  Nanos earliest = Nanos::max();
  for (const dispatch::SharedCoreSlot& slot : assignment_.cores[controller - pacers_.size()].slots) {
    earliest = std::min(earliest, first[slot.subchain.index()]);
  }
  return earliest == Nanos::max() ? Nanos{0} : earliest;
}

void Controllers::publish(policy::Assignment assignment) {
  take_over(std::move(assignment));
  for (std::size_t controller = 0; controller < count(); ++controller) nudge(controller, -1);
}

void Controllers::take_over(policy::Assignment assignment) {
  assignment.number = assignment_.number + 1;
  assignment_ = std::move(assignment);
  for (std::size_t index = 0; index < assignment_.places.size(); ++index) {
    nodes_.signal(SubchainId(index)).threads = assignment_.places[index].threads;
  }
}

void Controllers::nudge(std::size_t controller, int from_cpu) {
  sleeping_[controller].nudged = true;
  cpus_.wake(first_ + static_cast<Cpus::Thread>(controller), from_cpu);
}

Nanos Controllers::begin(Cpus::Thread thread, int cpu) {
  const std::size_t controller = thread - first_;
  Sleeping& sleeping = sleeping_[controller];
  const bool by_timer = !std::exchange(sleeping.nudged, false);
  sleeping.until =
      controller < pacers_.size() ? step(pacers_[controller], cpu) : step(cores_[controller - pacers_.size()], cpu);
  return by_timer ? costs_.dispatch_timer : costs_.dispatch_event;
}

bool Controllers::done(Cpus::Thread thread) {
  const Sleeping& sleeping = sleeping_[thread - first_];
  if (sleeping.nudged || sleeping.until <= cpus_.now()) return true;
  cpus_.wake_at(thread, sleeping.until);
  return false;
}

void Controllers::hold(SubchainId subchain, std::size_t controller, const os::CpuSet& cpus) {
  nodes_.signal(subchain).holder = controller;
  nodes_.move(subchain, cpus);
}

void Controllers::hand_over(SubchainId subchain, const dispatch::RunState& state) {
  nodes_.signal(subchain).wants_completions = false;
  handed_over_[subchain.index()] = state;
  const policy::SubchainPlace& place = assignment_.places[subchain.index()];
  nudge(place.core >= 0 ? number_of_core(place.core) : subchain.index(), -1);
}

// --- Of one subchain ---

TimePoint Controllers::step(Pacer& pacer, int cpu) {
  follow(pacer);
  if (!pacer.trigger) return kNever;
  Signal& signal = nodes_.signal(pacer.subchain);
  const dispatch::SubchainTrigger::Decision decision =
      pacer.trigger->step(cpus_.now(), std::min(signal.completed, pacer.trigger->sent()));
  if (decision.hang_began || decision.hang_ended) {
    pacer.contained = decision.hang_began;
    journal_.hang_changed(pacer.subchain, pacer.contained, cpus_.now());
    pacer.contained ? nodes_.set_level(pacer.subchain, os::Level::kOrdinary)
                    : nodes_.set_levels(pacer.subchain, pacer.place);
  }
  if (decision.trigger) {
    nodes_.trigger(pacer.subchain, pacer.trigger->sent(), cpu);
    journal_.triggered({pacer.subchain, pacer.trigger->sent(), *decision.trigger, cpus_.now()});
  }
  signal.wants_completions = decision.ask_on_completion;
  return decision.ask_at;
}

void Controllers::follow(Pacer& pacer) {
  const policy::SubchainPlace& place = assignment_.places[pacer.subchain.index()];
  const bool is_new = std::exchange(pacer.following, assignment_.number) != assignment_.number;
  std::optional<dispatch::RunState>& state = handed_over_[pacer.subchain.index()];
  if (place.core >= 0) {
    if (pacer.trigger) give_up(pacer);
  } else if (pacer.trigger) {
    if (!is_new || place == pacer.place) return;
    if (place.cpus != pacer.place.cpus) nodes_.move(pacer.subchain, place.cpus);
    const bool same_levels = place.level == pacer.place.level && place.levels == pacer.place.levels;
    if (!same_levels && !pacer.contained) nodes_.set_levels(pacer.subchain, place);
    if (place.pacing != pacer.place.pacing) pacer.trigger->change_pacing(cpus_.now(), place.pacing);
    pacer.place = place;
  } else if (state) {
    pacer.place = place;
    pacer.contained = state->hanging;
    hold(pacer.subchain, pacer.subchain.index(), place.cpus);
    if (!pacer.contained) nodes_.set_levels(pacer.subchain, place);
    TimePoint start = cpus_.now();
    if (state->sent > 0) start = std::max(start, state->triggered_at + place.pacing.period);
    pacer.trigger.emplace(start, place.pacing, state->sent, state->completed);
    state.reset();
  }
}

void Controllers::give_up(Pacer& pacer) {
  nodes_.set_level(pacer.subchain, os::Level::kOrdinary);
  dispatch::RunState state;
  state.sent = pacer.trigger->sent();
  state.completed = std::min(nodes_.signal(pacer.subchain).completed, state.sent);
  state.triggered_at = pacer.trigger->last_trigger();
  state.hanging = pacer.trigger->hanging();
  pacer.trigger.reset();
  hand_over(pacer.subchain, state);
}

// --- Of one core ---

TimePoint Controllers::step(Core& core, int cpu) {
  follow(core);
  core.progress.clear();
  for (const dispatch::SharedCoreSlot& slot : core.dispatcher.schedule().slots) {
    core.progress.push_back(nodes_.signal(slot.subchain).completed);
  }
  const dispatch::SharedCoreDispatcher::Decision& decision = core.dispatcher.step(cpus_.now(), core.progress);
  carry_out(core, decision, cpu);
  if (core.awaited != decision.wake_on_completion) {
    if (core.awaited) nodes_.signal(*core.awaited).wants_completions = false;
    core.awaited = decision.wake_on_completion;
  }
  if (core.awaited) nodes_.signal(*core.awaited).wants_completions = true;
  return decision.ask_at;
}

void Controllers::follow(Core& core) {
  const dispatch::SharedCoreSchedule& schedule = assignment_.cores[static_cast<std::size_t>(core.number)];
  if (core.following != assignment_.number) {
    core.following = assignment_.number;
    core.dispatcher.change_schedule(schedule);
    core.absent.clear();
    for (const dispatch::SharedCoreSlot& slot : schedule.slots) {
      if (nodes_.signal(slot.subchain).holder != number_of_core(core.number)) core.absent.push_back(slot.subchain);
    }
  }
  std::erase_if(core.absent, [&](SubchainId subchain) {
    std::optional<dispatch::RunState>& state = handed_over_[subchain.index()];
    if (!state) return false;
    hold(subchain, number_of_core(core.number), assignment_.places[subchain.index()].cpus);
    nodes_.set_level(subchain, os::Level::kOrdinary);
    core.dispatcher.adopt(subchain, *state);
    state.reset();
    return true;
  });
}

void Controllers::carry_out(Core& core, const dispatch::SharedCoreDispatcher::Decision& decision, int cpu) {
  for (const auto& [subchain, level] : decision.levels) nodes_.set_level(subchain, policy::to_os(level));
  for (const auto& [subchain, number, due] : decision.triggers) {
    nodes_.trigger(subchain, number, cpu);
    journal_.triggered({subchain, number, due, cpus_.now()});
  }
  for (const auto& slot : decision.slots) {
    journal_.slot_over({core.number, slot.subchain, slot.planned, slot.begin, slot.end});
  }
  for (const auto& steal : decision.steals) {
    if (steal.end) journal_.stole({core.number, steal.thief, steal.victim, steal.begin, *steal.end});
  }
  for (const auto& hang : decision.hangs) journal_.hang_changed(hang.subchain, hang.began, cpus_.now());
  for (const auto& [subchain, state] : decision.released) {
    if (core.awaited == subchain) core.awaited.reset();
    nodes_.signal(subchain).holder.reset();
    hand_over(subchain, state);
  }
}

}  // namespace ctn::sim
