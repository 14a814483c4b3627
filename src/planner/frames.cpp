#include "planner/frames.h"

#include "paper/paper.h"
#include "plan/validate.h"

namespace ctn::planner {

bool may_have_frames(const graph::App& app) {
  if (!app.exclusive.empty() && app.scheduler.schedule == graph::ScheduleKind::kAuto) return false;
  return app.scheduler.schedule != graph::ScheduleKind::kPriorities;
}
bool may_have_priorities(const graph::App& app) { return app.scheduler.schedule != graph::ScheduleKind::kFrames; }

Result<plan::Plan> make_plan_in_frames(const graph::App& app, const model::CostTable& costs,
                                       const FramesRequest& request) {
  Result<plan::Plan> plan =
      paper::make_plan(app, costs, {.cores = request.cores, .slack = request.slack, .steps = request.steps});
  if (!plan) return plan;
  if (Status valid = plan::validate(*plan, app, costs, request.cores); !valid) return valid.error();
  // The paper's stages are proven each for its own problem: of all plans that there are, nothing is.
  plan->planner = "auto";
  plan->quality = plan::Quality::kFeasible;
  plan->gap = 1.0;
  return plan;
}

}  // namespace ctn::planner
