// Rates by the method of Verucchi, Theile, Caccamo and Bertogna, "Latency-aware generation of single-rate DAGs from
// multi-rate task sets", RTAS 2020.
//
// A set of tasks with different rates becomes one graph of runs, over their hyperperiod. Between two tasks of different
// rates there are several ways to say which run uses which: each makes another graph. Of the graphs that can be
// scheduled, the one with the best reaction times and data ages is taken. That method is given the rates. To assign
// them with it, as one would who compares it with Catan, rates are searched: for each combination the graphs are built
// (job_dag.h), and the best weighted objective that can be scheduled wins.
//
// What is searched, and what not:
// - Periods are one base period times powers of two, up to 2^8: so hyperperiods are short. The base is the shortest
//   that the load of every core and the rate caps allow, or the one that exact rates dictate.
// - Of the ways to connect two tasks three are tried: wait for the newest run; use the newest that will have ended
//   by then under the schedule without any waiting; use the last of the producer's period before, which always has. The
//   same way for all runs of a pair, pair by pair, each at its best with the others as they are. Only pairs that
//   follow each other in a chain of the objective are connected.
// - Small apps (at most two million combinations of rates and cores): all combinations, in the order of a lower bound
//   of their objective, until none is left that could be better, or the effort is spent. Larger ones, and first:
//   descent from the rates that the weights suggest, one task's rate or core at a time. `exhaustive` says whether all
//   were looked at.
//
// What differs from the paper:
// - Instead of list scheduling on any core with a bound of Graham's kind, a subchain stays on one core, rate-monotonic
//   priorities pre-empt, and the schedule of the worst costs is worked out exactly. It is what a system with fixed
//   priorities can run, and the answer is sharper.
// - Reaction times are from the begin of a run, as Catan's response times are. The bounds are the bounds of this
//   schedule; they are no proof for runs that cost less and therefore meet others elsewhere.
// - What runs by its own clock (unscheduled nodes) is not in the graph: each adds its period and cost, and the part of
//   a chain behind it counts by itself.
//
// Units: see rate_plan.h. Thread safety: pure functions.
#pragma once

#include "base/result.h"
#include "baselines/rate_plan.h"

namespace ctn::baselines {

// `request.effort` counts runs put into graphs, a few hundred nanoseconds each. Errors (kCaller): see check_request;
// exact rates that are no powers of two apart; no combination found that keeps exact rates and caps.
Result<RatePlan> plan_by_verucchi(const graph::App& app, const model::CostTable& costs, const RateRequest& request);

}  // namespace ctn::baselines
