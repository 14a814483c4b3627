// What a schedule would come to: it is run in virtual time, at costs as measured. A planner calls this thousands of
// times to decide among schedules, so it is made to be fast: no threads, no kernel, no re-planning, and no more of the
// machine than what moves the figures. `sim` models all of that, and is what this is checked against.
//
//   const Samples samples(app, work, now, seed);
//   Trial trial(app, samples);
//   const Figures figures = trial.run(schedule_of(app, plan), {});
//
// How it goes:
//   schedule.h   which subchain runs where and when
//   samples.h    what each run costs
//   timers.h     when what happens next
//   cores.h      which run has a core
//   lineage.h    from runs to the terms of the objective
//   machine.h    triggers, runs, outputs: where these are put together
//
// By these rules:
//   - Cores of fixed priorities: of those with a run under way the one of the highest priority has the core. When a
//     subchain is triggered, and when a run beyond its budget is demoted, dispatch/subchain_trigger.h says; but no
//     leader is silent for so long that its followers are triggered without it.
//   - Cores of frames: the dispatcher itself (dispatch/shared_core_dispatcher.h) takes turns. At the background and
//     ordinary levels nodes have what is left in the order in which they came; no run is taken to hang.
//   - Pipelines: triggered by the same; nodes share the cores in the order in which they came, each of
//     their threads on one.
//   - Unscheduled nodes: above all, on an idle core if there is one, else where they ran last; the first run comes a
//     period after the start.
//   - Outputs: the newest, or all since the last run; none before the `output_period` is over, or but each so-many-th
//     run where that was measured; a run that emits none ends its subchain's run.
//   - Idle runs: a node for which that was measured does little and emits nothing where no predecessor has emitted, and
//     no clock of one has ticked, since its last run began.
//   - Input: a run that is triggered without news, of a node that needs some, waits for it, away from its core. A
//     schedule that waits for itself (a leader for what its follower gives) never runs, and so has no samples.
//   - Batches: a run of a queue node costs what its items add, those that it really takes.
//   - Clocks of external nodes: they tick at times of their own: unless told, each slides once through all phases, and
//     with it the subchains that keep a phase to it.
//   - Waits: in the middle of its CPU time a run may wait: it leaves its core to others, and goes on when a timer says
//     so. Of a run on several threads the first waits.
//
// What is left out: growth of costs during a trial; limits on real-time threads; fair scheduling of ordinary threads;
// chance in how long runs and the machine take beyond the draws.
//
// Units: in the types. The same questions get the same answers, to the bit. Thread safety: a Trial has one owner; any
// number of them may share an app and samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/ids.h"
#include "base/ticks.h"
#include "base/time.h"
#include "graph/app.h"
#include "trial/lineage.h"
#include "trial/samples.h"
#include "trial/schedule.h"

namespace ctn::trial {

// What it costs to schedule; the defaults are the averages of what `catan sim` assumes (sim/machine.h).
struct Overheads {
  // Delays.
  Nanos timer_latency = std::chrono::microseconds{5};  // from when a timer is due until its thread can run
  Nanos timer_jitter = std::chrono::microseconds{40};  // at most so much more, evenly spread
  // CPU time.
  Nanos run = std::chrono::microseconds{12};             // of each run
  Nanos context_switch = std::chrono::microseconds{2};   // of the thread that is switched to: a run, a controller
  Nanos dispatch_timer = std::chrono::microseconds{16};  // a controller that its timer woke
  Nanos dispatch_event = std::chrono::microseconds{8};   // that an output or the end of a run woke

  static Overheads none();
  // Where steps of controllers take so many times as long, until they sleep again; > 0.
  static Overheads with_steps(double factor);
};

// What happened in a run, as record::Run; for tests.
struct ObservedRun {
  struct Consumed {
    NodeId predecessor;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
  };
  NodeId node;
  std::uint64_t number = 0;  // from 1
  TimePoint begin{};
  TimePoint end{};
  bool emitted = true;
  std::vector<Consumed> consumed;
};

class Observer {
 public:
  virtual ~Observer() = default;
  // Each after those that it consumed.
  virtual void ended(const ObservedRun& run) = 0;
};

struct Options {
  Nanos horizon = std::chrono::seconds{60};  // that is measured, > 0
  Nanos warm_up = std::chrono::seconds{2};   // before, >= 0
  std::uint32_t first_draw = 0;              // of the samples: another is another chance
  Nanos since{0};                            // the first triggers by time: periods that differ meet at other phases
  bool p95 = false;                          // takes longer
  Overheads overheads{};
  // Of external nodes that tick and of unscheduled ones that follow none (their begins), by NodeId. Without a period,
  // and beyond the end: slowly sliding through all phases.
  std::vector<Ticks> clocks{};
  // What reaches the end of a chain less than that before its clock ticks is taken to miss that tick.
  Nanos before_ticks{0};
  Observer* observer = nullptr;  // sees all runs, those of the warm-up too; null: none
};

struct TermFigures {
  double mean_ms = 0.0;   // of so few samples (see Figures::enough), the horizon or more
  double p95_ms = 0.0;    // if asked for; 0 where there is no sample
  std::size_t count = 0;  // samples: all that they span lies in the horizon
};

struct SubchainFigures {
  double period_ms = 0.0;  // between the ends of two runs; 0: fewer than two
  std::size_t runs = 0;    // that ended in the horizon
};

struct Figures {
  std::vector<TermFigures> terms;  // in the order of the objective
  double objective = 0.0;          // the weighted sum of means
  bool enough = true;              // samples of each term to say something of it: kMinSamples
  std::vector<double> busy;        // by core: fraction of the horizon, unscheduled nodes and controllers included
  std::vector<SubchainFigures> subchains;  // by SubchainId
  std::uint64_t events = 0;
};

// A term of which there are fewer counts as if each had taken the whole horizon, at least.
constexpr std::size_t kMinSamples = 3;

class Trial {
 public:
  // Both outlive it.
  Trial(const graph::App& app, const Samples& samples) : app_(app), samples_(samples), prefixes_(app) {}

  // Preconditions: one place a subchain; cores that are named exist, in the app too where it lists its cores; where a
  // place says kFrames or kPipeline, there is a slot or a pipeline for the subchain.
  Figures run(const Schedule& schedule, const Options& options) const;

 private:
  const graph::App& app_;
  const Samples& samples_;
  ChainPrefixes prefixes_;
};

}  // namespace ctn::trial
