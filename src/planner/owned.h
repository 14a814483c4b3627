// The best use of cores that one subchain has for itself.
//
// For each number of cores k' from 1 up to what is there, and each number of threads q from 1 to k', the model gives a
// period and an execution time. A max_rate stretches the period, an exact rate sets it. For a given k' the q wins that
// needs the least relaxation of bounds, then has the least L + p. Among the k' the one wins that needs the least
// relaxation, then has the best objective, then is smallest: a core more never makes the plan worse, and cores that are
// of no use are left alone.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::planner {

// A whole plan for an app of one subchain, save for `Plan::planner`. Preconditions: just one subchain; 1 <= cores; 0 <=
// slack < 1.
Result<plan::Plan> plan_owned(const graph::App& app, const model::CostTable& costs, int cores, double slack);

}  // namespace ctn::planner
