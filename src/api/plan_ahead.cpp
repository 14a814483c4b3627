#include "api/plan_ahead.h"

#include "paper/paper.h"
#include "policy/planned.h"

namespace ctn::api {

Result<plan::Plan> plan_ahead(const graph::App& app, const KnownCosts& known, const planner::ExpectedRequest& request,
                              graph::PlannerKind by) {
  Result<plan::Plan> plan = by == graph::PlannerKind::kPaper
                                ? paper::make_plan(app, known.costs, {.cores = request.cores, .slack = request.slack})
                                : planner::make_expected_plan(app, known.samples, known.costs, request);
  if (plan) policy::say_what_is_known(*plan, known.costs, {}, app.graph);
  return plan;
}

}  // namespace ctn::api
