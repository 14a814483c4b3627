// The best plan of another allocation. Few subchains: of all allocations. More: of the plan's neighbours, those that
// differ by one subchain moved, two swapped, or one core given to another owner.
//
// Better is what the planner means by it: a smaller relax factor first, then a smaller objective.
//
// Thread safety: pure functions.
#pragma once

#include "planner/explain.h"

namespace ctn::planner {

// Preconditions: as of `explain`.
RunnerUp runner_up_of(const graph::App& app, const model::CostTable& costs, const Request& request,
                      const plan::Plan& plan);

}  // namespace ctn::planner
