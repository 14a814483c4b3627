// When to plan anew, and when a new plan is worth a swap. Pure.
//
// Units: in the types. Thread safety: ReplanClock has one owner; the rest are pure functions.
#pragma once

#include "base/time.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::runtime {

// A new plan replaces one in force if it moves a subchain to other cores or changes a period or an execution time,
// planned or expected, by more than this part: percentiles over a window of 50 runs wander by about as much when
// nothing has changed.
constexpr double kSwapThreshold = 0.02;

// A run that takes so many times as long as planned, and at least this long, is taken to hang.
constexpr int kHangMultiple = 10;
constexpr Nanos kShortestHang = std::chrono::seconds{1};

bool worth_a_swap(const plan::Plan& current, const plan::Plan& candidate);

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
