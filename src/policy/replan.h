// When to re-plan, and when a new plan is worth a swap. Pure.
//
// Units: in the types. Thread safety: ReplanClock has one owner; the rest are pure functions.
#pragma once

#include <cstddef>
#include <optional>

#include "base/time.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "policy/plan_reason.h"
#include "policy/planning_budget.h"
#include "policy/policy.h"

namespace ctn::policy {

// What a new plan must differ by to replace the one in force: percentiles over a window of 50 runs wander by about as
// much when nothing has changed.
constexpr double kSwapThreshold = 0.02;    // in the objective; in a time of a subchain that owns its cores
constexpr double kOverrunThreshold = 0.1;  // by which runs have outgrown their slices on a shared core
constexpr double kStaleThreshold = 0.1;    // in what the plan in force would promise now

// A run that takes so many times as long as planned, and at least this long, is taken to hang.
constexpr int kHangMultiple = 10;
constexpr Nanos kShortestHang = std::chrono::seconds{1};
// With a fixed priority, where the plan rests on compute times that are assumed: others above may take seconds that
// no plan foresaw.
constexpr Nanos kShortestHangIfAssumed = std::chrono::seconds{5};

// `current_now`: the plan in force at the compute times of the candidate (plan/recost.h); none where it cannot hold any
// more. A candidate is worth it if
//   - it does better than the plan in force would now, by more than noise: a lower factor of relaxed bounds, or a lower
//     objective under the same factor;
//   - a subchain that owns its cores would be paced differently, since it is paced by its own measured times;
//   - on a shared core, runs no longer fit their slices (with elastic frames, shorter runs need no new plan), or the
//     promises of the plan in force have become wrong;
//   - what the plan in force says of relaxed bounds has become wrong.
bool worth_swapping(const plan::Plan& current, const std::optional<plan::Plan>& current_now,
                    const plan::Plan& candidate);

// The pacing of a subchain that owns its cores; a run hangs that takes ten times as long as planned, and at least a
// second.
//
// With fixed frames, and for an exact rate, it is the planned period. With elastic ones (the default) the subchain is
// paced by its own output, at the period and the execution time that the plan expects: runs that cost less than the
// planned percentile let it go faster, and the slack stays idle for ordinary threads all the same. It never goes faster
// than a rate cap allows. A plan without an expectation is taken at its word.
dispatch::Pacing pacing_of(const graph::App& app, const plan::Plan& plan, SubchainId subchain);

// Changes are answered at once, but no sooner than this after the plan before: one cause (a clock that was lowered, a
// map that grew) shows in several nodes within some runs.
constexpr Nanos kChangeSpacing = std::chrono::milliseconds{250};

// Between the end of the bootstrap and the first sample that counts: the first measured plan comes into force and what
// was under way under the old one ends.
constexpr Nanos kSettle = std::chrono::milliseconds{500};

// The plan in force, when another is made that may replace it.
class Incumbent {
 public:
  // At the compute times of the other, which is made for `why`. `plan` outlives it.
  Incumbent(const plan::Plan& plan, PlanReason why, const graph::App& app, const model::CostTable& costs,
            const model::CostTable& typical);

  // At any rate to what is made because this one rests on no measurement or cannot be followed any more, else to what
  // is worth a swap.
  bool yields_to(const plan::Plan& candidate) const;

 private:
  const plan::Plan& plan_;
  bool unconditional_;
  std::optional<plan::Plan> now_;  // the plan at the new compute times
};

// What is to come into force in place of `in_force`, where something is: whatever is decided, if `in_force` follows no
// plan. Errors: the policy's.
Result<std::optional<Decision>> replacement(const Policy& policy, const Situation& situation, const Decision& in_force);

// When a plan is due. The first that rests on measurements: when the bootstrap is over and any scheduled node has run.
// Further ones every `interval`, or every kChangeSpacing while the policy has more to try; when a node has run that had
// not before, or when something has changed permanently; all as the budget allows. `known`: how many scheduled nodes
// have run; never falls. `more`: the policy has.
class ReplanClock {
 public:
  ReplanClock(TimePoint start, const graph::SchedulerOptions& options) : ReplanClock(start, options, options.replan) {}
  // `saved`: as the budget's.
  ReplanClock(TimePoint start, const graph::SchedulerOptions& options, Nanos interval, Nanos saved = Nanos{0})
      : due_(start + options.bootstrap), interval_(interval), budget_(saved) {}

  // Something has changed: kChange, kPower. What came first is named when the plan is due.
  void changed(PlanReason what);

  std::optional<PlanReason> due(TimePoint now, std::size_t known, bool more = false) const;
  // A plan was begun at `now` for that reason, due or not, and took `cpu` to make.
  void made(TimePoint now, PlanReason why, Nanos cpu, std::size_t known);

  // How many of the plans made last were periodic, without another in between.
  int periodic() const { return periodic_; }
  const PlanningBudget& budget() const { return budget_; }

 private:
  TimePoint due_;
  Nanos interval_;
  bool measured_plan_made_ = false;
  std::size_t known_ = 0;  // when the last plan was made
  TimePoint last_{};       // when a plan was made, once one was
  std::optional<PlanReason> change_;
  int periodic_ = 0;
  PlanningBudget budget_;
};

}  // namespace ctn::policy
