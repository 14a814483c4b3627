// The planner of the least expected objective: `--planner auto`. What it compares is what schedules really come to in
// virtual time, at costs as they are distributed, not what formulas promise of them (schedule_search.h). Beside
// schedules of fixed priorities it tries one in frames (frames.h), if there is one.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <functional>
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
  // A plan of the app, or of one with as many subchains, to begin with; used if it has no frames. May be null.
  const plan::Plan* known = nullptr;
  Freedom freedom{};  // of schedules with fixed priorities
  // Called now and then with the part of the search that is done, up to 1.
  std::function<void(double)> on_progress{};
};

// `samples` are of the app; `costs` the percentiles that promises go by. The plan is valid for `costs`, and has what is
// expected of it. Errors (kCaller): as of check_request() and unattainable() (formulas.h); where the app is to have
// frames alone, as of make_plan_in_frames().
Result<plan::Plan> make_expected_plan(const graph::App& app, const trial::Samples& samples,
                                      const model::CostTable& costs, const ExpectedRequest& request);

// What is expected of a plan, as a trial of its schedule found it: at most what it promises.
plan::Expectation expectation_of(const graph::App& app, const plan::Plan& plan, const trial::Schedule& schedule,
                                 const Expected& expected);

}  // namespace ctn::planner
