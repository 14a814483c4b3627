// The public planning: files in, the planner that the app file names, JSON out.
#include "catan/planning.h"

#include <fmt/format.h>

#include "api/plan_ahead.h"
#include "config/app_file.h"
#include "paper/paper.h"
#include "plan/json.h"

namespace ctn {

Result<std::string> make_plan(const std::string& app_file, const PlanningOptions& options) {
  const Result<graph::App> loaded = config::load_app(app_file);
  if (!loaded) return loaded.error();
  if (!(options.effort >= api::kMinEffort && options.effort <= api::kMaxEffort)) {
    return Error::caller(fmt::format("an effort of {}", options.effort),
                         fmt::format("give one from {} to {}", api::kMinEffort, api::kMaxEffort));
  }
  const bool by_paper = loaded->scheduler.planner == graph::PlannerKind::kPaper;
  const graph::App app = by_paper ? paper::as_in_the_paper(*loaded) : *loaded;
  const Result<api::KnownCosts> known = api::known_costs(options.costs, app);
  if (!known) return known.error();
  const int cores = options.cores != 0 ? options.cores : app.core_count().value_or(1);
  const double slack = app.scheduler.slack.value_or(graph::kDefaultSlack);
  const Result<plan::Plan> plan = api::plan_ahead(
      app, *known, {.cores = cores, .slack = slack, .effort = options.effort}, loaded->scheduler.planner);
  if (!plan) return plan.error();
  return plan::to_json(*plan, app);
}

}  // namespace ctn
