// A plan that is made ahead of a run, by compute times that are known: what `catan plan` prints and make_plan() gives.
//
// Units: in the types. Thread safety: pure functions.
#pragma once

#include "api/known_costs.h"
#include "base/result.h"
#include "graph/app.h"
#include "plan/plan.h"
#include "planner/expected.h"

namespace ctn::api {

// Of a search (planner::ExpectedRequest::effort).
inline constexpr double kMinEffort = 0.001;
inline constexpr double kMaxEffort = 1000.0;

// By the paper's planner `app` is as paper::as_in_the_paper() makes it. The plan says which nodes give fewer outputs
// than they have runs. Errors: the planner's.
Result<plan::Plan> plan_ahead(const graph::App& app, const KnownCosts& known, const planner::ExpectedRequest& request,
                              graph::PlannerKind by);

}  // namespace ctn::api
