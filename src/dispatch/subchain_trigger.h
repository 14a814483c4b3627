// When to trigger the head of a subchain: the pure state machine that driver/subchain_pacer.h carries out. It is told
// the time and how far the subchain's runs have come, and answers what to do now and when to ask again. It reads no
// clock and makes no call, so the real runtime and virtual time drive the very same code.
//
// Two ways to pace:
//   gated    (Catan, a subchain that owns its cores or has a fixed priority) every period, but never while as many runs
//            are under way as its cores can overlap: then as soon as one has ended. A run that takes longer than
//            planned delays the next one instead of competing with it for the cores.
//   ungated  (hand-set rates) every period, whatever the runs do, as a sensor's own timer would.
//
// Four ways to tell when a trigger is due:
//   by period  a period after the last one. Triggers keep to a grid (a late one does not shift the next) until one is a
//              whole period late: then the grid restarts from it.
//   by phase   at phase + k periods of the clock, so that subchains keep their phases to each other, on whichever cores
//              and through whichever plans. Nothing shifts this grid: however many of its points pass while a run is
//              under way, one trigger makes up for them as soon as that has ended, and the next one is due at the next
//              point. Where the grid changes, or another controller held the subchain before, the next trigger is due
//              at the first point that is half a period or more after the last trigger: on the same grid that is the
//              next point, on another one nearest to a period. One that has just passed (a kJustPassed-th of a period
//              ago at most) is due at once: where the new grid is a little earlier than the old one, on which the
//              trigger was not due yet, neither point would come otherwise, and none for nearly two periods.
//              The clock may be one that is not ours, as a display's (align()): the grid then begins at its ticks, and
//              follows it as it drifts, by no more than a kSlewed-th of a period with each trigger. Where what is known
//              of the clock has changed by more than a quarter of its period, the grid is another one. Until something
//              is known of it the grid is the system's clock's.
//   elastic    paced by its own output: where m runs overlap, the run that is m triggers later is due when, after the
//              end of this one, m periods less one execution have passed. On one core that is the idle time after each
//              run; in a pipeline the input then reaches the longest node when it is ready for it. Runs shorter than
//              expected let it go faster; an input that has to wait makes it go slower until none has to.
//   after      by each so-many-th output of its leader, which is another subchain or an unscheduled node, counted from
//              when it begins to follow it.
//              Too often: outputs that come while a run is under way, or too soon after the last trigger, count, and
//              one trigger follows when that is over. `shortest` between triggers holds on average (a token bucket of
//              one token), and most of it between any two (plan::held_apart()). So a leader that floods its follower
//              triggers it no more often than that; but a trigger that came late, as its output did or since a run was
//              under way, does not make the next ones late: they come sooner until they are on time again.
//              Too seldom: a leader that is missing, stalled or slow, or that itself needs what its follower gives
//              before it gives anything, does not silence its follower. That is triggered all the same, and then once
//              a period until there are outputs again:
//                after silence_limit() without a trigger;
//                after kFirstOutputWithin, or a period, where the leader has never given an output;
//                after idle_limit(), and only while it runs, where the leader runs and gives nothing. This is sooner,
//                and breaks no promise (plan/promise.h): where the leader cannot run, there is no trigger before
//                silence_limit().
//
// A run with a budget of CPU time is demoted when it has used more: its threads go below all that has a priority, until
// the next trigger is due. If the run has ended by then there is a trigger; else it gets a budget again in place of
// one. Either way the threads get their level back. So a subchain never takes more from those below it than its budget
// once a period, which is what they were promised; and one whose runs have become much longer than planned still gets
// on at the rate that it was planned with. That is for one run at a time (max_in_flight 1) on one CPU, where a run
// cannot have used its budget sooner than as long after its trigger. Then the state machine asks to be told what the
// run has used; where that is less, since the run was pre-empted, it asks again when the rest could be used up. What it
// costs while runs keep to their budgets: the clocks of their threads are read once at the trigger, and one timer
// passes a run, unless the next trigger comes first. Only while a run is still under way by then, which was pre-empted,
// are clocks read again, and another timer set; the less often, the longer it has got no CPU time at all, for each look
// takes the CPU from what pre-empts it.
//
// After a standstill (standstill.h) a run under way is watched for hanging again.
//
// Units: Nanos, TimePoint. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "base/ticks.h"
#include "base/time.h"
#include "dispatch/standstill.h"
#include "graph/app.h"
#include "plan/limits.h"
#include "plan/plan.h"

namespace ctn::dispatch {

// How a subchain is to be triggered; a value that the plan gives.
struct Pacing {
  Nanos period{0};        // > 0
  int max_in_flight = 0;  // runs under way at most; 0: ungated
  Nanos hang_after{0};    // a run under way for longer is taken to hang; 0: never
  // Elastic: the next trigger comes this long after a run has ended, or a period after the last trigger where none has;
  // 0: always the latter.
  Nanos after_completion{0};
  Nanos shortest{0};  // between two triggers, at least
  // Fixed priorities.
  std::optional<Nanos> phase{};        // triggers come at phase + k periods of the clock; none: from the first one on
  std::optional<NodeId> clock{};       // whose ticks the phase counts from; none: the system's clock
  TickCount ticks{};                   // of that clock, that a period lasts
  std::optional<plan::After> after{};  // in place of time: each so-many-th output of a leader, expected every `period`
  Nanos budget{0};                     // CPU time of a run; one beyond it is demoted until a trigger is due. 0: any

  friend bool operator==(const Pacing&, const Pacing&) = default;
};

using graph::kShortestPeriod;

// By no more than this part of its period a grid is moved with each trigger: far more than quartzes ask for, and so
// little that no run feels it.
constexpr Nanos::rep kSlewed = 250;

// A point of a new grid is due yet where it has passed no longer ago than this part of a period.
constexpr Nanos::rep kJustPassed = 16;

// What a run has used is not looked at more often, since looking takes about as long. So it may use that much more than
// its budget.
constexpr Nanos kBudgetGrain = std::chrono::microseconds{50};

// Nor more often than this while it gets no CPU time at all: each look comes after twice the time of the one before, up
// to this. So a run that could not go on just before its budget was used up may use up to this much more.
constexpr Nanos longest_budget_grain(Nanos budget) {
  return std::clamp<Nanos>(budget / 8, kBudgetGrain, std::chrono::milliseconds{1});
}

// The pacing of a subchain that owns its cores: as many runs overlap as a run is periods long (rounded up), which is
// one on one core.
Pacing pacing_of_owned(Millis period, Millis execution, Nanos hang_after);

// The same, paced by its own output; `shortest` >= 0.
Pacing elastic_pacing_of_owned(Millis period, Millis execution, Nanos hang_after, Nanos shortest);

// How a subchain is paced that owns its cores: by its own output, at what is expected of it; where frames are fixed or
// its rate is exact, by time, as promised.
struct OwnerTimes {
  plan::Expectation::Timing promised;
  plan::Expectation::Timing expected;
};
Pacing pacing_of_owner(const OwnerTimes& times, const plan::PeriodLimits& limits, bool fixed_frames, Nanos hang_after);

// The same of a subchain in a plan. Precondition: it owns its cores.
Pacing pacing_of_owner(const graph::App& app, const plan::Plan& plan, SubchainId subchain, Nanos hang_after);

// When the next trigger is due of a subchain that is paced so from `now` on; `last`: when it was triggered last.
TimePoint first_due(const Pacing& pacing, TimePoint now, std::optional<TimePoint> last);

// For so long, or a period, a follower waits for the first output that its leader ever gives.
constexpr Nanos kFirstOutputWithin = std::chrono::seconds{1};

constexpr Nanos silence_limit(const Pacing& pacing) { return plan::silence_limit(pacing.period); }

// For so long a follower waits for outputs of a leader that runs: two periods, and at least a second.
constexpr Nanos idle_limit(const Pacing& pacing) { return std::max<Nanos>(2 * pacing.period, std::chrono::seconds{1}); }

class SubchainTrigger {
 public:
  // The first trigger is due at `start` (first_due()), or where it follows another subchain by the first outputs after
  // that. A subchain that was triggered by others before goes on counting: `sent` of them, of which the runs up to
  // `completed` have ended. `hanging`: so was told of the run under way, or the one that ended last.
  SubchainTrigger(TimePoint start, const Pacing& pacing, std::uint64_t sent = 0, std::uint64_t completed = 0,
                  bool hanging = false);

  struct Decision {
    bool restore = false;              // before the trigger is sent, if one is: the run was demoted
    std::optional<TimePoint> trigger;  // send a trigger now; when it was due
    bool demote = false;               // the run under way has used more than its budget
    bool hang_began = false;           // the oldest run under way has just become one that hangs
    bool hang_ended = false;           // ... and has come to an end after all
    TimePoint ask_at{};                // ask again then,
    bool ask_on_completion = false;    // or as soon as a run ends
  };

  // `completed`: the newest trigger whose run has ended, counted from 1; triggers that were overtaken count as ended.
  // Time never goes backwards; a call may come early, late, or twice.
  Decision step(TimePoint now, std::uint64_t completed);

  // --- before a step ---
  // Where it follows another: how many outputs that has given, and when the newest came; where that is a subchain, also
  // how many of its runs have ended, with output or without. All may be anything. To be told, and stepped, as soon as
  // there are awaited_outputs(): fewer change nothing.
  void hear(TimePoint now, std::uint64_t outputs, TimePoint newest, std::optional<std::uint64_t> runs = std::nullopt);
  // Precondition: it follows another, and has heard of it.
  std::uint64_t awaited_outputs() const { return *counted_ + outputs_a_trigger(); }
  // Where its phase is to a clock of others: what is known of that now. To be told whenever it is stepped.
  void align(TimePoint now, const Ticks& clock);
  // Whether used() is to be called: the CPU time of the run under way, since its trigger.
  bool wants_cpu_time(TimePoint now, std::uint64_t completed) const;
  void used(TimePoint now, Nanos cpu);

  // Takes effect at once. A pacing that says the same of when triggers are due changes nothing of that, and one that is
  // owed since a run is under way stays so. Else the next trigger is due one new period after the last one, or now if
  // that has passed; by phase, see above; elastic, the new idle time after the last run has ended, if none is under
  // way: the period of such a one is how long it may take, which may be long. Where runs may overlap it waits for all
  // that are under way, so that what piled up in front of a slow node under the old pacing does not stay there under
  // the new one. The budget of a run under way is the new one.
  void change_pacing(TimePoint now, const Pacing& pacing);
  // The CPU time of the run under way counts from now on.
  void restart_budget(TimePoint now);

  std::uint64_t sent() const { return sent_; }
  TimePoint last_trigger() const { return last_due_; }
  bool hanging() const { return hanging_; }
  bool demoted() const { return demoted_; }

 private:
  bool may_overlap(std::uint64_t completed) const;
  std::uint64_t outputs_a_trigger() const;
  Nanos shortest() const;
  TimePoint ready() const;
  Ticks grid_of(const Ticks& clock) const;
  TimePoint next_by_clock(TimePoint now);
  void schedule_next(TimePoint now);
  void spend_trigger(TimePoint now);
  void give_budget(TimePoint now);
  bool leader_runs() const;
  bool never_heard() const;
  TimePoint due_without_output() const;
  TimePoint look_at_leader(TimePoint now) const;
  void watch(TimePoint now, std::uint64_t completed, Decision& decision);
  void limit(TimePoint now, Decision& decision);

  Pacing pacing_;
  TimePoint due_;
  TimePoint last_due_;
  std::uint64_t sent_ = 0;
  std::uint64_t completed_ = 0;
  TimePoint progress_at_;              // when a run last ended, or the first of those under way began
  std::optional<TimePoint> ended_at_;  // when a run was last seen to have ended
  bool hanging_ = false;
  TimePoint asked_for_ = kNever;  // the next call

  // By a clock of others.
  std::optional<Ticks> clock_;  // what is known of it
  std::optional<Ticks> grid_;   // that it gave, as far as it has followed it
  bool grid_is_new_ = false;    // and no trigger was due on it yet

  // Where it follows another subchain.
  std::optional<std::uint64_t> counted_;  // outputs, up to the newest that made a trigger due; none: not heard yet
  TimePoint heard_at_{};
  std::optional<TimePoint> output_due_;       // a trigger is due since the output that came then
  TimePoint silent_since_;                    // the last trigger
  TimePoint held_from_;                       // when it should have come, on average; `shortest` before it, at most
  std::optional<std::uint64_t> leader_runs_;  // that have ended
  std::uint64_t leader_runs_before_ = 0;      // ... by the last trigger
  enum class Came {
    kAsPlanned,
    kWhileLeaderRan,  // and gave nothing
    kWithoutOutput,   // of a leader that did not run, or has never given one
  };
  Came came_ = Came::kAsPlanned;  // the last trigger

  // The budget of the run under way.
  Nanos allowed_{0};            // CPU time since its trigger
  Nanos used_{0};               // as told last
  TimePoint look_at_ = kNever;  // it cannot be used up before
  Nanos grain_ = kBudgetGrain;  // no sooner than so long after a look comes the next
  bool over_budget_ = false;    // it is used up, as was just told
  bool demoted_ = false;
};

}  // namespace ctn::dispatch
