// A plan in some milliseconds of CPU time, by formulas alone: where nothing has run yet, where an exact rate cannot be
// met, and where only what is promised is asked for. What schedules really come to is for expected.h.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstddef>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "planner/frames.h"
#include "trial/samples.h"

namespace ctn::planner {

struct FormulaRequest {
  int cores = 1;                        // 1 to kMaxCores; of those that the app lists, the first so many
  double slack = graph::kDefaultSlack;  // fraction in [0, 1)
  std::size_t guesses = 6000;           // by formulas of means, below a microsecond each and subchain
  std::size_t frame_steps = kFrameStepsAtRunTime;
  // Whether an error says how many cores would do, for which it plans again and again.
  bool count_cores = true;
};

// Fixed priorities, as formulas of means find them (surrogate.h). Valid for `costs`. Errors (kCaller): as of
// check_request(); unattainable().
Result<plan::Plan> make_guessed_plan(const graph::App& app, const trial::Samples& samples,
                                     const model::CostTable& costs, const FormulaRequest& request);

// In frames, if the app may have them and they can be had; else by guesses. Frames come first because they keep what
// the slack leaves to ordinary threads even if runs cost far more than they are taken to; a schedule of fixed
// priorities rests on what they cost. Errors: as above.
Result<plan::Plan> make_plan_by_formulas(const graph::App& app, const model::CostTable& costs,
                                         const FormulaRequest& request);

// Why there is no plan: how much its exact rates lack, and how many cores would do. Precondition: check_request()
// holds.
Error unattainable(const graph::App& app, const model::CostTable& costs, const FormulaRequest& request);

}  // namespace ctn::planner
