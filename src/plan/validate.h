// Proves a plan against the app it is for, whatever made it: the planner, a file, a person.
//
// It goes from the ground up and stops where what follows would rest on sand: first the shape (one entry a subchain and
// core, every number finite and not negative, every index in range), then which subchain has which core, then each core
// group by its own formula, then rates, then what the plan promises (chains, nodes, objective, relaxed bounds).
//
// It does not prove that no better plan exists: that is the planner's claim, in `quality` and `gap`.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

// What a plan claims and the costs it was made for must agree: every subchain has its cores and no core two owners;
// slices, offsets and frames add up; periods, response times and the objective follow from the formulas (to one part in
// 10^9); rate caps hold; bounds hold or are named as relaxed. All violations at once, each under its path in the plan's
// JSON; kCaller, because a plan may come from a file. Precondition: core_count >= 0.
Status validate(const Plan& plan, const graph::App& app, const model::CostTable& costs, int core_count);

// What can be proven of a plan without the compute times that it was made for: shape, which subchain has which core,
// slots and frames, rate caps and exact rates.
Status validate_layout(const Plan& plan, const graph::App& app, int core_count);

}  // namespace ctn::plan
