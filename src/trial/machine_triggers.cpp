// Subchains of fixed priorities, and pipelines: what triggers them is the state machine that their controllers follow
// in life (dispatch/subchain_trigger.h, driver/subchain_pacer.h).
#include <algorithm>

#include "plan/limits.h"
#include "trial/machine.h"

namespace ctn::trial {
namespace {

// Of what waits for an event: until then, nothing is due by time. In life that is when a leader has been silent for
// long; here it gives too few samples then, whatever its followers do.
constexpr Nanos kNotByTime = std::chrono::hours{24};

}  // namespace

dispatch::Pacing Machine::pacing_of(const Place& place) const {
  const Nanos period = std::max(place.period, dispatch::kShortestPeriod);
  dispatch::Pacing pacing{.period = period, .max_in_flight = 1, .shortest = period, .budget = place.budget};
  if (place.after || place.pause) pacing.period = kNotByTime;
  if (place.after) {
    pacing.after = place.after;
  } else if (place.pause) {
    pacing.after_completion = std::max(*place.pause, Nanos{1});
  } else if (place.clock) {
    pacing.phase = place.phase;
    pacing.clock = place.clock;
    const Millis nominal = to_millis(*app_.graph.node(*place.clock).period);
    pacing.ticks = plan::ticks_of(to_millis(place.period), nominal).value_or(TickCount{});
  } else {
    pacing.phase = place.phase - options_.since;
  }
  return pacing;
}

void Machine::start_pacing(std::size_t index) {
  Subchain& subchain = subchains_[index];
  const Place& place = *subchain.place;
  const dispatch::Pacing pacing = pacing_of(place);
  if (place.after) {
    subchain.trigger.emplace(TimePoint{}, pacing);
    return subchain.trigger->hear(TimePoint{}, 0, TimePoint{});
  }
  const Ticks grid{TimePoint{} + place.phase - options_.since, pacing.shortest};
  const TimePoint first = place.clock ? TimePoint{} : grid.next(TimePoint{});
  subchain.trigger.emplace(first, pacing);
  set_timer(source_of_subchain(index), first, subchain.timers_set);
}

// The subchain's controller looks, and what is decided is carried out.
void Machine::pace(Subchain& subchain, WokenBy by) {
  const auto job = static_cast<Job>(subchain.id.index());
  const Place& place = *subchain.place;
  dispatch::SubchainTrigger& trigger = *subchain.trigger;
  hold(core_of_controller(subchain), by);
  if (place.after) trigger.hear(now_, subchain.leader_outputs, now_);
  if (place.clock) trigger.align(now_, clocks_[place.clock->index()]);
  if (trigger.wants_cpu_time(now_, subchain.completed)) trigger.used(now_, cores_.used(job, now_));
  const dispatch::SubchainTrigger::Decision decision = trigger.step(now_, subchain.completed);
  if (decision.demote) set_rank(job, kDemoted);
  if (decision.restore && under_way(subchain)) set_rank(job, subchain.rank);
  if (decision.demote || decision.restore) touch(place.core);
  if (decision.trigger) {
    place.form == Form::kPipeline ? wake(pipes_[*pipe_of_subchain_[job]], 0, trigger.sent())
                                  : begin_first_node(subchain);
  }
  subchain.awaits_completion = decision.ask_on_completion;
  const Timers::Source source = source_of_subchain(job);
  if (decision.ask_at > warm_from_ + options_.horizon) {
    timers_.set(source, kNever);
  } else {
    set_timer(source, decision.ask_at, subchain.timers_set);
  }
}

// Precondition: no run of it is under way.
void Machine::begin_first_node(Subchain& subchain) {
  subchain.position = 0;
  cores_.add_work(static_cast<Job>(subchain.id.index()), subchain.place->core, subchain.rank);
  touch(subchain.place->core);
}

// That of a pipeline runs on one of its own cores.
int Machine::core_of_controller(const Subchain& subchain) const {
  if (subchain.place->form != Form::kPipeline) return subchain.place->core;
  const std::vector<int>& cores = pipes_[*pipe_of_subchain_[subchain.id.index()]].pipeline->cores;
  const auto idle = std::find_if(cores.begin(), cores.end(), [&](int core) { return cores_.idle(core); });
  return idle != cores.end() ? *idle : cores.front();
}

void Machine::hear_output(const std::vector<std::size_t>& followers) {
  for (const std::size_t index : followers) {
    Subchain& follower = subchains_[index];
    if (++follower.leader_outputs >= follower.trigger->awaited_outputs()) pace(follower, WokenBy::kEvent);
  }
}

}  // namespace ctn::trial
