// Core allocation: who owns cores, who shares which. Two ways:
//   joint      the allocation whose best shares (stage II) are best of all
//   two-stage  stage I picks the allocation as if all that share a core took equal shares; stage II then finds the
//   shares
//
// Joint, few subchains: under given multipliers (shares.h) what a group of subchains costs does not depend on the other
// groups, so dynamic programming over sets of subchains gives the least total, which is a lower bound on every plan.
// All partitions whose bound is below the best plan known are then looked at, the most promising first, until none is
// left: the result is proven.
// Joint, more subchains: local search (moves, swaps, cores given and taken) finds a plan; set partitioning with groups
// made as they are needed (cover.h) bounds all others, and names those that may be better. Where these are few the
// result is proven; else the plan says how far from the optimum it can be at most.
// Joint, more than 64: the same, but what no effort is left for is not done (shares.h): mostly the bounds that know of
// whole numbers in groups, so that gaps are wider, not wrong.
//
// Identical cores are not told apart, so that no allocation is looked at twice.
//
// Units: milliseconds. Thread safety: pure functions.
#pragma once

#include "planner/instance.h"
#include "planner/shares.h"

namespace ctn::planner {

struct Planned {
  bool found = false;
  Allocation allocation;
  Shares shares;
  double bound = 0.0;  // proven: nothing is better
};

// The best allocation and shares for the target. `warm`: an allocation to begin with, perhaps of an earlier plan;
// `known`: a plan that meets the target's limits, its value that of the target. Either may be null. Nothing is found
// that is not below `cutoff`, which may be infinite.
Planned plan_jointly(const Instance& instance, const Target& target, const Allocation* warm, const Planned* known,
                     double cutoff, Effort& effort);

// Exact rates leave few allocations that can be had at all, and a search may miss them: one where each has cores of its
// own, the fewest that do. `bound`: what is proven of all allocations.
Planned plan_exact_apart(const Instance& instance, const Target& target, double bound, Effort& effort);

// Stage I: the best allocation under equal shares; exact. Not found where rates leave none.
Planned allocate_by_equal_shares(const Instance& instance, const Target& target, Effort& effort);

// The timings that stage I reckons with.
std::vector<Timing> equal_shares(const Instance& instance, const Allocation& allocation);

// The best shares for an allocation that is given.
Planned plan_shares(const Instance& instance, const Target& target, const Allocation& allocation, Effort& effort);

}  // namespace ctn::planner
