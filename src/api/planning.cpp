// The public planning: files in, the planner that the app file names, JSON out.
#include "catan/planning.h"

#include <fmt/format.h>

#include "api/known_costs.h"
#include "config/app_file.h"
#include "paper/paper.h"
#include "plan/json.h"
#include "planner/expected.h"
#include "policy/planned.h"

namespace ctn {
namespace {

constexpr double kMinEffort = 0.001;
constexpr double kMaxEffort = 1000.0;

}  // namespace

Result<std::string> make_plan(const std::string& app_file, const PlanningOptions& options) {
  const Result<graph::App> loaded = config::load_app(app_file);
  if (!loaded) return loaded.error();
  if (!(options.effort >= kMinEffort && options.effort <= kMaxEffort)) {
    return Error::caller(fmt::format("an effort of {}", options.effort),
                         fmt::format("give one from {} to {}", kMinEffort, kMaxEffort));
  }
  const bool by_paper = loaded->scheduler.planner == graph::PlannerKind::kPaper;
  const graph::App app = by_paper ? paper::as_in_the_paper(*loaded) : *loaded;
  const Result<api::KnownCosts> known = api::known_costs(options.costs, app);
  if (!known) return known.error();
  const int cores = options.cores != 0 ? options.cores : app.core_count().value_or(1);
  const double slack = app.scheduler.slack.value_or(graph::kDefaultSlack);
  Result<plan::Plan> plan =
      by_paper ? paper::make_plan(app, known->costs, {.cores = cores, .slack = slack})
               : planner::make_expected_plan(app, known->samples, known->costs,
                                             {.cores = cores, .slack = slack, .effort = options.effort});
  if (!plan) return plan.error();
  policy::say_what_is_known(*plan, known->costs, {}, app.graph);
  return plan::to_json(*plan, app);
}

}  // namespace ctn
