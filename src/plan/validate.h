// Proves a plan against the app it is for.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

// What a plan claims and the costs it was made for must agree: every subchain has its cores and no core two owners;
// slices, offsets and frames add up; periods, response times and the objective follow from the formulas (to one part in
// 10^9); rate caps hold; bounds hold or are named as relaxed. All violations at once; kCaller, because a plan may come
// from a file.
Status validate(const Plan& plan, const graph::App& app, const model::CostTable& costs, int core_count);

}  // namespace ctn::plan
