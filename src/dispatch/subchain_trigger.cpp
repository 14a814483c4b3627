#include "dispatch/subchain_trigger.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>
#include <utility>

#include "plan/limits.h"

namespace ctn::dispatch {

Pacing pacing_of_owned(Millis period, Millis execution, Nanos hang_after) {
  const Millis paced = std::max(period, Millis{kShortestPeriod});
  // A run that is a hair longer than its period (rounding) does not need a second one at the same time.
  const double overlap = std::ceil(execution / paced - 1e-9);
  return {.period = to_nanos(paced), .max_in_flight = std::max(1, static_cast<int>(overlap)), .hang_after = hang_after};
}

Pacing elastic_pacing_of_owned(Millis period, Millis execution, Nanos hang_after, Nanos shortest) {
  Pacing pacing = pacing_of_owned(period, execution, hang_after);
  pacing.after_completion = std::max(pacing.period * pacing.max_in_flight - to_nanos(execution), Nanos{1});
  pacing.shortest = std::max(shortest, kShortestPeriod);
  return pacing;
}

Pacing pacing_of_owner(const OwnerTimes& times, const plan::PeriodLimits& limits, bool fixed_frames, Nanos hang_after) {
  const auto& [promised, expected] = times;
  if (fixed_frames || limits.exact) return pacing_of_owned(promised.period, promised.execution, hang_after);
  return elastic_pacing_of_owned(expected.period, expected.execution, hang_after, to_nanos(limits.min));
}

Pacing pacing_of_owner(const graph::App& app, const plan::Plan& plan, SubchainId subchain, Nanos hang_after) {
  const plan::SubchainPlan& planned = plan.subchains[subchain.index()];
  return pacing_of_owner({{planned.period, planned.execution}, plan::usual_timing(plan, subchain)},
                         plan::period_limits(app.graph, subchain), plan::has_fixed_frames(app, plan.cores, planned),
                         hang_after);
}

namespace {

// In a period, where its leader could have run meanwhile.
constexpr int kLooks = 8;

bool is_elastic(const Pacing& pacing) { return pacing.after_completion > Nanos{0} && !pacing.after; }

bool has_phase(const Pacing& pacing) { return pacing.phase && !pacing.after && pacing.after_completion == Nanos{0}; }

bool by_period(const Pacing& pacing) { return !pacing.after && !is_elastic(pacing) && !has_phase(pacing); }

// The first point of the grid that is not before `earliest`.
TimePoint grid_point(const Pacing& pacing, TimePoint earliest) {
  return Ticks{TimePoint{} + *pacing.phase, pacing.period}.next(earliest);
}

// Where the grid changes: no point before this is due any more, on a grid of that period.
TimePoint first_on_new_grid(TimePoint now, TimePoint last, Nanos period) {
  return std::max(now - period / kJustPassed, last + period / 2);
}

}  // namespace

TimePoint first_due(const Pacing& pacing, TimePoint now, std::optional<TimePoint> last) {
  if (pacing.after) return now;
  // If its run is still under way, its end says when the next one is due.
  if (is_elastic(pacing) && pacing.max_in_flight == 1) return last ? std::max(now, *last + pacing.shortest) : now;
  if (!has_phase(pacing)) return last ? std::max(now, *last + pacing.period) : now;
  return grid_point(pacing, last ? first_on_new_grid(now, *last, pacing.period) : now);
}

SubchainTrigger::SubchainTrigger(TimePoint start, const Pacing& pacing, std::uint64_t sent, std::uint64_t completed,
                                 bool hanging)
    : pacing_(pacing),
      due_(has_phase(pacing) ? grid_point(pacing, start) : start),
      last_due_(start),
      sent_(sent),
      completed_(completed),
      progress_at_(start),
      hanging_(hanging),
      silent_since_(start),
      held_from_(start),
      allowed_(pacing.budget) {
  assert(pacing.period > Nanos{0} && completed <= sent);
}

bool SubchainTrigger::may_overlap(std::uint64_t completed) const {
  if (pacing_.max_in_flight == 0) return true;
  return sent_ - completed < static_cast<std::uint64_t>(pacing_.max_in_flight);
}

void SubchainTrigger::watch(TimePoint now, std::uint64_t completed, Decision& decision) {
  const bool progress = completed > completed_;
  completed_ = completed;
  const bool under_way = sent_ > completed_;
  if (progress || !under_way) progress_at_ = now;
  if (pacing_.hang_after == Nanos{0} || !under_way || hanging_) return;
  if (now - progress_at_ >= pacing_.hang_after) {
    hanging_ = true;
    decision.hang_began = true;
  } else {
    decision.ask_at = std::min(decision.ask_at, progress_at_ + pacing_.hang_after);
  }
}

std::uint64_t SubchainTrigger::outputs_a_trigger() const {
  return static_cast<std::uint64_t>(std::max(pacing_.after ? pacing_.after->every : 1, 1));
}

void SubchainTrigger::hear(TimePoint now, std::uint64_t outputs, TimePoint newest, std::optional<std::uint64_t> runs) {
  if (runs && (!leader_runs_ || *runs < *leader_runs_)) leader_runs_before_ = *runs;
  leader_runs_ = runs;
  const TimePoint heard_before = std::exchange(heard_at_, now);
  if (!counted_ || outputs < *counted_) {
    counted_ = outputs;
    return;
  }
  const std::uint64_t every = outputs_a_trigger();
  const std::uint64_t triggers = (outputs - *counted_) / every;
  if (triggers == 0) return;
  *counted_ += triggers * every;
  if (!output_due_) output_due_ = std::clamp(newest, heard_before, now);
}

bool SubchainTrigger::wants_cpu_time(TimePoint now, std::uint64_t completed) const {
  return pacing_.budget > Nanos{0} && sent_ > std::max(completed, completed_) && !hanging_ &&
         now >= (demoted_ ? ready() : look_at_);
}

void SubchainTrigger::used(TimePoint now, Nanos cpu) {
  const bool got_on = cpu != used_;
  grain_ = got_on ? kBudgetGrain : std::min(2 * grain_, longest_budget_grain(pacing_.budget));
  used_ = cpu;
  over_budget_ = cpu > allowed_;
  look_at_ = now + std::max(allowed_ - cpu, grain_);
}

void SubchainTrigger::restart_budget(TimePoint now) {
  used_ = Nanos{0};
  give_budget(now);
}

// Beyond what the run under way has used.
void SubchainTrigger::give_budget(TimePoint now) {
  over_budget_ = false;
  grain_ = kBudgetGrain;
  allowed_ = used_ + pacing_.budget;
  look_at_ = now + std::max(pacing_.budget, kBudgetGrain);
}

// After watch(), which knows what is under way.
void SubchainTrigger::limit(TimePoint now, Decision& decision) {
  const bool over_budget = std::exchange(over_budget_, false);
  if (pacing_.budget == Nanos{0} || sent_ <= completed_ || demoted_ || hanging_) return;
  if (over_budget && !decision.trigger) {
    demoted_ = true;
    decision.demote = true;
    // A trigger that was owed would be a budget at once.
    if (now >= ready()) spend_trigger(now);
    decision.ask_at = std::min(decision.ask_at, ready());
  } else {
    decision.ask_at = std::min(decision.ask_at, std::max(look_at_, now));
  }
}

// The grid that the clock asks for.
Ticks SubchainTrigger::grid_of(const Ticks& clock) const {
  return {clock.numbered(pacing_.ticks.ticks) + *pacing_.phase, pacing_.ticks.of(clock.period)};
}

void SubchainTrigger::align(TimePoint now, const Ticks& clock) {
  if (!pacing_.clock || !has_phase(pacing_)) return;
  clock_ = clock;
  if (grid_) return;
  grid_ = grid_of(clock);
  grid_is_new_ = true;
  // A trigger that is owed comes when it can.
  if (due_ <= now && sent_ > 0) return;
  due_ = grid_->next(sent_ == 0 ? now : first_on_new_grid(now, last_due_, grid_->period));
  grid_is_new_ = false;
}

// The first point after `now` of the grid as it was, or so much nearer to the clock's.
TimePoint SubchainTrigger::next_by_clock(TimePoint now) {
  const Ticks wanted = grid_of(*clock_);
  const TimePoint due = grid_->next(now + Nanos{1});
  const Nanos late = wanted.next(due) - due;
  const Nanos off = late <= wanted.period / 2 ? late : wanted.last(due) - due;
  if (std::exchange(grid_is_new_, false) || std::max(off, -off) > clock_->period / 4) {
    grid_ = wanted;
    return wanted.next(now + wanted.period / 2);
  }
  const Nanos max = wanted.period / kSlewed;
  grid_ = Ticks{std::max(due + std::clamp(off, -max, max), now), wanted.period};
  return grid_->tick;
}

void SubchainTrigger::schedule_next(TimePoint now) {
  if (pacing_.after) {
    output_due_.reset();
    last_due_ = now;
  } else if (has_phase(pacing_)) {
    due_ = grid_ ? next_by_clock(now) : grid_point(pacing_, now + Nanos{1});
    last_due_ = due_ - (grid_ ? grid_->period : pacing_.period);
  } else {
    const bool off_grid = now - due_ >= pacing_.period;
    last_due_ = off_grid || pacing_.after_completion > Nanos{0} ? now : due_;
    due_ = last_due_ + pacing_.period;
  }
}

// What is due now is a trigger, or a budget in place of it.
void SubchainTrigger::spend_trigger(TimePoint now) {
  const bool as_planned = !pacing_.after || output_due_;
  came_ = as_planned                        ? Came::kAsPlanned
          : leader_runs() && !never_heard() ? Came::kWhileLeaderRan
                                            : Came::kWithoutOutput;
  silent_since_ = now;
  held_from_ = std::max(now - shortest(), std::min(held_from_ + shortest(), now));
  leader_runs_before_ = leader_runs_.value_or(0);
  schedule_next(now);
  if (pacing_.after) due_ = due_without_output();
}

// Since the last trigger. Where that came of an output, the first run may be the one that gave it, since its end can be
// seen later.
bool SubchainTrigger::leader_runs() const {
  const std::uint64_t known = came_ == Came::kWhileLeaderRan ? 0 : 1;
  return leader_runs_ && *leader_runs_ - leader_runs_before_ > known;
}

bool SubchainTrigger::never_heard() const { return counted_ && *counted_ == 0; }

TimePoint SubchainTrigger::due_without_output() const {
  if (came_ == Came::kWithoutOutput) return silent_since_ + pacing_.period;
  if (never_heard()) return silent_since_ + std::max(pacing_.period, kFirstOutputWithin);
  if (!leader_runs()) return silent_since_ + silence_limit(pacing_);
  return silent_since_ + (came_ == Came::kWhileLeaderRan ? pacing_.period : idle_limit(pacing_));
}

// When a trigger may be due since the leader has run, which nothing tells. Else kNever.
TimePoint SubchainTrigger::look_at_leader(TimePoint now) const {
  if (!pacing_.after || !leader_runs_ || leader_runs() || output_due_) return kNever;
  const TimePoint first = silent_since_ + (came_ == Came::kWhileLeaderRan ? pacing_.period : idle_limit(pacing_));
  return first > now ? first : now + std::max(pacing_.period / kLooks, kShortestPeriod);
}

Nanos SubchainTrigger::shortest() const { return std::max(pacing_.shortest, kShortestPeriod); }

// Outputs may come at any rate: their writer is not trusted.
TimePoint SubchainTrigger::ready() const {
  if (!pacing_.after || sent_ == 0) return due_;
  const Nanos apart = std::max(plan::held_apart(shortest()), kShortestPeriod);
  return std::max({due_, held_from_ + shortest(), silent_since_ + apart});
}

SubchainTrigger::Decision SubchainTrigger::step(TimePoint now, std::uint64_t completed) {
  assert(completed <= sent_);
  if (stood_still(asked_for_, now)) progress_at_ = now;
  Decision decision;
  decision.ask_at = kNever;
  completed = std::max(completed, completed_);
  if (hanging_ && (completed > completed_ || completed == sent_)) {
    hanging_ = false;
    decision.hang_ended = true;
    // What ends the suspension restores the level.
    demoted_ = false;
  }
  const bool paced_by_output = is_elastic(pacing_);
  if (completed > completed_) ended_at_ = now;
  if (paced_by_output && completed > completed_) {
    due_ = std::max(now + pacing_.after_completion, last_due_ + pacing_.shortest);
  }
  if (pacing_.after) due_ = output_due_.value_or(due_without_output());

  if (now >= ready() && may_overlap(completed)) {
    decision.trigger = due_;
    if (sent_ == completed) progress_at_ = now;
    ++sent_;
    decision.restore = std::exchange(demoted_, false);
    restart_budget(now);
    spend_trigger(now);
  } else if (now >= ready() && demoted_ && !hanging_) {
    decision.restore = true;
    demoted_ = false;
    give_budget(now);
    spend_trigger(now);
  }
  if (may_overlap(completed)) {
    decision.ask_at = std::max(ready(), now);
  } else {
    decision.ask_on_completion = now >= ready();
    decision.ask_at = decision.ask_on_completion ? kNever : ready();
  }
  if (!decision.ask_on_completion) decision.ask_at = std::min(decision.ask_at, look_at_leader(now));
  watch(now, completed, decision);
  limit(now, decision);
  if (paced_by_output) decision.ask_on_completion = true;
  // A run that hangs is watched for its end, to restore its level.
  if (hanging_) decision.ask_on_completion = true;
  asked_for_ = decision.ask_at;
  return decision;
}

void SubchainTrigger::change_pacing(TimePoint now, const Pacing& pacing) {
  assert(pacing.period > Nanos{0});
  const Pacing before = std::exchange(pacing_, pacing);
  const bool same_leader = before.after && pacing.after && before.after->leader == pacing.after->leader;
  if (!same_leader) {
    counted_.reset();
    output_due_.reset();
    leader_runs_.reset();
    came_ = Came::kAsPlanned;
  }
  const auto grid = [](const Pacing& of) { return std::tuple(of.clock, of.phase, of.period); };
  if (!has_phase(before) || !has_phase(pacing) || grid(before) != grid(pacing)) grid_.reset();
  if (has_phase(pacing)) {
    const bool owed = has_phase(before) && due_ <= now;
    if (!owed && !grid_) due_ = first_due(pacing, now, sent_ == 0 ? std::nullopt : std::optional(last_due_));
  } else if (is_elastic(pacing) && sent_ == completed_ && ended_at_) {
    due_ = std::max({now, *ended_at_ + pacing.after_completion, last_due_ + pacing.shortest});
  } else if (sent_ > 0 && !(by_period(before) && by_period(pacing) && before.period == pacing.period)) {
    due_ = std::max(last_due_ + pacing.period, now);
  }
  held_from_ = std::max(held_from_, silent_since_ - shortest());
  if (pacing.budget == Nanos{0}) demoted_ = false;
  if (before.budget == Nanos{0}) return restart_budget(now);
  allowed_ = pacing.budget;
  look_at_ = now;
}

}  // namespace ctn::dispatch
