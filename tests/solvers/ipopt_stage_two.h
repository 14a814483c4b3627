// Stage II without whole numbers, for an allocation that is given: a convex program, solved by Ipopt. On each shared
// core with frame T,
//
//   sum_i C_i / p_i <= usable,   T <= p_i <= most_i T   (queue nodes: p_i <= most_i T),
//
// rate caps and exact rates bound p_i, and maxima of linear forms are variables that are at least each of the forms. No
// shares in whole numbers are better than its optimum.
//
// Units: milliseconds. Thread safety: Ipopt's linear solver keeps global state; one call at a time.
#pragma once

#include <limits>
#include <vector>

#include "planner/instance.h"
#include "planner/shares.h"

namespace ctn::solvers {

struct StageTwo {
  bool solved = false;  // to the solver's tolerance; false also where there is no solution
  double value = std::numeric_limits<double>::infinity();
  std::vector<planner::Timing> timings;  // by subchain
};

StageTwo ipopt_stage_two(const planner::Instance& instance, const planner::Target& target,
                         const planner::Allocation& allocation);

}  // namespace ctn::solvers
