// The planner of the least expected objective: `--planner auto`. What it compares is what schedules really come to in
// virtual time, at costs as they are distributed, not what formulas promise of them (schedule_search.h). Beside
// schedules of fixed priorities it tries the formulas' best plan (planner.h), which may have frames, or several cores
// for one subchain.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "planner/schedule_search.h"
#include "trial/samples.h"

namespace ctn::planner {

struct ExpectedRequest {
  int cores = 1;                        // 1 to kMaxCores; of those that the app lists, the first so many
  double slack = graph::kDefaultSlack;  // fraction in [0, 1)
  double effort = 1.0;                  // how long to search, as a multiple of a few seconds; > 0
  std::uint64_t seed = 1;
};

// `samples` are of the app; `costs` the percentiles that promises go by. The plan is valid for `costs`, and has what is
// expected of it. Errors (kCaller): as of make_plan().
Result<plan::Plan> make_expected_plan(const graph::App& app, const trial::Samples& samples,
                                      const model::CostTable& costs, const ExpectedRequest& request);

// A schedule that was found, as a plan. None where somebody has no fixed priority, or no promise within reach.
// Preconditions: as search_schedule().
std::optional<plan::Plan> plan_of(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                                  const Found& found, double slack);

}  // namespace ctn::planner
