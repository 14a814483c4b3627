// Stage I as the paper writes it: a mixed-integer linear program over who is on which core, solved by CBC. It knows
// nothing of how the planner goes about it: where the planner chooses sizes of groups, this chooses cores.
//
//   a[i][x]  subchain i may run on core x
//   z[x][m]  core x is shared by m subchains
//   y[i][m]  subchain i is one of m on a single core; its period is then m C / usable, or that of its one own core
//   o[i][k]  subchain i owns k >= 2 cores
//
// Maxima of linear forms are variables that are at least each of the forms. Cores may stay empty.
//
// Units: milliseconds. Thread safety: CBC keeps global state; one call at a time.
#pragma once

#include <limits>

#include "planner/instance.h"
#include "planner/shares.h"

namespace ctn::solvers {

struct StageOne {
  bool found = false;
  bool proven = false;  // optimal, or infeasible where nothing was found
  // Of the allocation below, by the periods of equal shares: CBC's own figure has its tolerances in it.
  double value = std::numeric_limits<double>::infinity();
  planner::Allocation allocation;
};

StageOne cbc_stage_one(const planner::Instance& instance, const planner::Target& target,
                       double seconds = std::numeric_limits<double>::infinity());

}  // namespace ctn::solvers
