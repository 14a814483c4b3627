// A hyperperiod of tasks whose rates are harmonic, as one graph of runs: which run of which predecessor each run uses
// and waits for, when it begins and ends, and what that means for chains. The heart of verucchi.h.
//
// Tasks are triggered together at 0 and from then on each every `every` units of time. A run that is triggered at R
// uses, of each predecessor, the last run that was triggered at or before R - delay, and begins no sooner than that one
// has ended. Of the runs that may run on a core, the one with the highest priority does; runs pre-empt each other; each
// must end before the next of its task is triggered, so that every hyperperiod is like the first.
//
// Units: of time, as the caller likes. Thread safety: plain values, pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace ctn::baselines {

struct DagTask {
  double cost = 0.0;
  int every = 1;  // units; of any two tasks one's is a multiple of the other's
  int core = 0;
  int priority = 0;  // distinct; a higher one pre-empts
};

struct DagEdge {
  int from = 0;
  int to = 0;
  int delay = 0;  // units, >= 0, a multiple of the shorter `every`
};

struct DagRun {
  double begin = 0.0;
  double end = 0.0;
};

struct DagSchedule {
  int hyperperiod = 1;
  std::vector<std::vector<DagRun>> runs;  // by task, in the order of their triggers, over one hyperperiod

  // Of any run, before the first hyperperiod (below 0) or after it.
  DagRun run(std::size_t task, long number) const;
};

// How many runs a hyperperiod has: what scheduling it costs.
std::size_t runs_of(std::span<const DagTask> tasks);

// None where a run would end too late, or where runs wait for each other in a circle.
std::optional<DagSchedule> schedule_dag(std::span<const DagTask> tasks, std::span<const DagEdge> edges);

// The number of the run that `edge.from` lends to run `number` of `edge.to`; below 0 of hyperperiods before.
long used_run(std::span<const DagTask> tasks, const DagEdge& edge, long number);

// A chain's worst times under the schedule: `reaction` from the begin of a first run that reached the end to the end of
// the last run that used the next such; `age` from the begin of a first run to the end of the last run that used it.
struct DagLatency {
  double reaction = 0.0;
  double age = 0.0;
};
// `row[i]` is the edge from the chain's i-th task to the next. Precondition: they fit; empty: the chain is `first`.
DagLatency chain_latency(std::span<const DagTask> tasks, const DagSchedule& schedule, int first,
                         std::span<const DagEdge> row);

}  // namespace ctn::baselines
