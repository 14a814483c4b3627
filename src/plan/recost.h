// The same plan at other compute times: which subchain has which cores, every n, share and number of threads stay;
// slices, frames, periods and predictions follow from the new times. What a plan in force would give now, compared with
// which a new one has to be better.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <optional>

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

// None where an exact rate would be out of reach. Its quality is kFeasible with a gap of 1: nothing is proven of it.
// Slices may be shorter than min_slice. Precondition: the plan is valid for the app at some compute times.
std::optional<Plan> recost(const Plan& plan, const graph::App& app, const model::CostTable& costs);

}  // namespace ctn::plan
