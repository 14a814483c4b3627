// From schedules that a search finds to plans that promise: what is tried has no promises, and formulas only guess
// them. Here they are computed and checked.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <optional>

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "planner/schedule_search.h"
#include "trial/samples.h"
#include "trial/schedule.h"

namespace ctn::planner {

// A schedule of fixed priorities as a plan that is valid (plan/validate.h), without what is expected of it. None where
// there is no such plan: a subchain has no fixed priority or no promise within reach, or what the app asks for is not
// kept. Precondition: the schedule is one of a ScheduleSearch's.
std::optional<plan::Plan> plan_of(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                                  const trial::Schedule& schedule, double slack);

struct Promised {
  plan::Plan plan;  // without what is expected of it
  trial::Schedule schedule;
};

// Of all that the search has found the best that is valid at its costs, with bounds relaxed as far as the plan says;
// where nothing is, a slowed one. `frames`: the plan of the one found that has frames, if there is one. None: exact
// rates are out of reach, or batches are. Precondition: `frames` is valid at the search's costs.
std::optional<Promised> best_promised(const ScheduleSearch& search, const graph::App& app, int cores, double slack,
                                      const std::optional<plan::Plan>& frames = {});

}  // namespace ctn::planner
