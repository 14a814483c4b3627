// The plan in frames that stands beside what the search finds: the paper's allocation and shares (paper/paper.h), with
// the frames that the app asks for. An app that triggers badly by fixed priorities may do better in frames, and they
// keep what the slack leaves to ordinary threads whatever runs cost.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstddef>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::planner {

// Steps of each of the paper's stages: while an app runs, 20 ms of CPU time for 64 subchains; and where a user waits
// for the plan.
constexpr std::size_t kFrameStepsAtRunTime = 20'000;
constexpr std::size_t kFrameSteps = 400'000;

struct FramesRequest {
  int cores = 1;                        // of those that the app lists, the first so many
  double slack = graph::kDefaultSlack;  // fraction in [0, 1)
  std::size_t steps = kFrameSteps;
};

// Whether an app may be planned in frames, and by fixed priorities.
bool may_have_frames(const graph::App& app);
bool may_have_priorities(const graph::App& app);

// Valid for the app. Errors (kCaller): as of paper::make_plan().
Result<plan::Plan> make_plan_in_frames(const graph::App& app, const model::CostTable& costs,
                                       const FramesRequest& request);

}  // namespace ctn::planner
