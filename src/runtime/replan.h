// When to plan anew, and when a new plan is worth a swap. Pure.
//
// Units: in the types. Thread safety: ReplanClock has one owner; the rest are pure functions.
#pragma once

#include <optional>

#include "base/time.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::runtime {

// What a new plan must differ by to replace the one in force: percentiles over a window of 50 runs wander by about as
// much when nothing has changed.
constexpr double kSwapThreshold = 0.02;    // in the objective; in a time of a subchain that owns its cores
constexpr double kOverrunThreshold = 0.1;  // by which runs have outgrown their slices on a shared core
constexpr double kStaleThreshold = 0.1;    // in what the plan in force would promise now

// A run that takes so many times as long as planned, and at least this long, is taken to hang.
constexpr int kHangMultiple = 10;
constexpr Nanos kShortestHang = std::chrono::seconds{1};

// `current_now`: the plan in force at the compute times of the candidate (plan/recost.h); none where it cannot hold any
// more. A candidate is worth it if
//   - it does better than the plan in force would now, by more than noise: a lower factor of relaxed bounds, or a lower
//     objective under the same;
//   - a subchain that owns its cores would be paced differently: what it is paced by are its own measured times;
//   - on a shared core, runs do not fit their slices any more (with elastic frames shorter runs need nothing new), or
//   the
//     promises of the plan in force have become wrong.
bool worth_a_swap(const plan::Plan& current, const std::optional<plan::Plan>& current_now, const plan::Plan& candidate);

// The pacing of a subchain that owns its cores; a run hangs that takes ten times as long as planned, and at least a
// second.
//
// With fixed frames, and for an exact rate, it is the planned period. With elastic ones (the default) the subchain is
// paced by its own output, at the period and the execution time that the plan expects: runs that cost less than the
// planned percentile let it go faster, and the slack stays idle for ordinary threads all the same. It never goes faster
// than a rate cap allows. A plan without an expectation is taken at its word.
dispatch::Pacing pacing_of(const graph::App& app, const plan::Plan& plan, SubchainId subchain);

// The first plan that rests on measurements is due when the bootstrap is over and every node has run; further ones
// every `replan`.
class ReplanClock {
 public:
  ReplanClock(TimePoint start, const graph::SchedulerOptions& options)
      : due_(start + options.bootstrap), interval_(options.replan) {}

  bool due(TimePoint now, bool all_measured) const { return now >= due_ && (all_measured || measured_plan_made_); }
  bool first() const { return !measured_plan_made_; }
  void made(TimePoint now) {
    measured_plan_made_ = true;
    due_ = now + interval_;
  }

 private:
  TimePoint due_;
  Nanos interval_;
  bool measured_plan_made_ = false;
};

}  // namespace ctn::runtime
