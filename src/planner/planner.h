// From an app, what its nodes cost, and a number of cores, to a plan. Pure and deterministic: values in, plan out.
//
// At present it plans apps of one subchain, which owns all cores it can use; a second subchain is refused with an error
// that says so.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::planner {

struct Request {
  int cores = 1;                        // >= 1; 0 is an error
  double slack = graph::kDefaultSlack;  // fraction in [0, 1)
};

// Errors (kCaller): no cores; an app that needs what the planner cannot do; rates that cannot be met together.
Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request);

}  // namespace ctn::planner
