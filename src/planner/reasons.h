// What binds each subchain's period in a plan: one step of `explain`.
//
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "planner/explain.h"
#include "planner/instance.h"

namespace ctn::planner {

// Solvers approach a bound from inside, and stop when they are this near.
constexpr double kMet = 1e-6;

// Those of the plan, as the instance has them: as if no run waited.
std::vector<Timing> timings_of(const Instance& instance, const plan::Plan& plan);

// By SubchainId. `bounds`: in the order of `instance.bounds`.
std::vector<Reason> reasons_of(const graph::App& app, const model::CostTable& costs, const Instance& instance,
                               const plan::Plan& plan, const std::vector<BoundCost>& bounds);

}  // namespace ctn::planner
