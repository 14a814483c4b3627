// What subchains with fixed priorities are promised: response-time analysis.
//
// A run of i takes, from its trigger to its end, at worst
//   R_i = C_i + sum over j above i on its core of ceil((R_i + J_j) / T_j) C_j
// (Joseph and Pandya, 1986; release jitter by Audsley and others, 1993), where C is the compute time at the planned
// percentile, divided by what the slack leaves of a core; T_j is the least time between two triggers of j, on average
// over many; and J_j is how much closer together than that some of them may come: those of a subchain that is late
// because of its own long runs, or that is triggered by outputs which are sometimes early. Of a subchain that is
// triggered by outputs or by a pause, no two triggers are closer together than its period: where that says less (J = 0
// and T = period), it counts. Without it there may be no bound at all: if a subchain runs below one that it triggers,
// response and jitter grow with one another. Outputs of an unscheduled node come at its period, each as late as its own
// run and those of the nodes that it follows may end, with what these wait (model/unscheduled.h).
//
// While a run of i is pending, nothing below it on its core runs. So those above it that go back to outputs of one that
// is not above it come once each, and not again before i has ended: where all on the way from that one to j are on this
// core and never wait, j comes at most as often as there are subchains on that way, since each of them may have kept
// one trigger back until its period was over. That is where i does not wait and R_i is below silence_limit() of j
// (plan/limits.h), beyond which it would be triggered without outputs. So subchains that take turns have a promise,
// however full their core is.
//
// One that is above its leader on its core, where that one has a pause after each run, is over before its leader has
// run again. So of the leader's runs from one of its triggers to the next, one is longer by it, and the others take
// what they take without it.
//
// A run of i may wait (model/cost.h) for w_i in all, and others have the core meanwhile. Then w_i is added to its R_i.
// For those below it there are two bounds, and the lesser holds: C_i + w_i in place of C_i, as if it kept the core; or
// R_i - C_i more jitter, since what a run leaves undone while it waits it may do just before its next run, so that both
// come close together. Its wait alone would not be enough, since the run may be interrupted before and after it. See
// Chen, Nelissen, Huang and others, "Many suspensions, many problems: a review of self-suspending tasks in real-time
// systems" (Real-Time Systems 55, 2019), which lists that among the mistakes that were made; the bound by jitter is of
// Huang, Chen, Zhou and Liu, "PASS: priority assignment of real-time tasks with dynamic suspending behavior under
// fixed-priority scheduling" (DAC 2015).
//
// Exclusive groups (Sha, Rajkumar and Lehoczky, "Priority inheritance protocols: an approach to real-time
// synchronization", IEEE Transactions on Computers 39, 1990). A run of a node below i on its core may hold an exclusive
// group that i wants, or a subchain above i there, or an unscheduled node. It is raised and goes on, so the longest
// such run is added to R_i: once for each exclusive group, and once more for each node of i if i may leave its core
// before it has ended. For each exclusive group that one of i's own nodes is in, R_i also has
//   - runs of each unscheduled node of that group, with what they wait (below),
//   - runs of each subchain on another core that has a node in it, each from trigger to end: as many as may come while
//     the run of i is pending, and one more.
// If a subchain above i may wait while it holds an exclusive group of i's, its wait counts as work. A run may be kept
// away from its core by a node that has its exclusive group and is unscheduled, waits, or is on another core. Such a
// run may come closer to its subchain's next one, just as a run that waits (see above). Where a run below i may delay
// i, something below i runs while i is pending; then what is said above of outputs of one that is not above i does not
// hold for i. Frames and pipelines are taken to know of no exclusive group.
//
// Unscheduled nodes are above all members of all cores, and may take any core. So each of them counts as one more j
// above i, whichever core i is on: T_j is its period, and J_j how late its run may end.
//
// p_i is the longer of R_i and of what lies between two triggers, on average over many. Of outputs that trigger it one
// may be late and the next one early: what waits for its next run may wait for longer than p_i (predict.cpp). Where not
// every run of its leader gives an output (model/cost.h), p_i is a mean over these too; T is as if each did.
//
// Where many short runs interrupt a long one, the sum is bounded from above by a line (ceil(x) <= x + 1), which is
// a little more than the worst case.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include <optional>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

struct Promise {
  Millis period{0};     // p
  Millis execution{0};  // L: R
  Millis spacing{0};    // T
};

// Whatever takes longer is not promised at all.
constexpr Millis kLongestPromise = std::chrono::hours{24};

// By SubchainId; period and execution are 0 for those without a fixed priority. None where the subchains above leave
// some subchain no time. Preconditions: shapes as validate() checks them; a subchain triggered by another one's outputs
// does not trigger that one, directly or by others.
std::optional<std::vector<Promise>> promise(const Plan& plan, const graph::App& app, const model::CostTable& costs);

}  // namespace ctn::plan
