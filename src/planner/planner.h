// From an app, what its nodes cost, and a number of cores, to a plan. Pure and deterministic: values in, plan out.
//
// At present it plans apps of one subchain, which owns all cores that it can use (owned.h); a second subchain is
// refused with an error that says so.
//
// What it makes satisfies `plan::validate`. It reads no clock: `Plan::solve_time` is left 0, for the caller to fill in.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::planner {

// As many as Linux can name in an affinity mask of default size.
constexpr int kMostCores = 1024;

// How cores are divided among subchains: as one problem with the shares, or before them. Where one subchain has all the
// cores there is nothing to divide, and both make the same plan.
enum class Method { kJoint, kTwoStage };

struct Request {
  int cores = 1;                        // 1 to kMostCores
  double slack = graph::kDefaultSlack;  // fraction in [0, 1)
  Method method = Method::kJoint;
};

// Errors (kCaller): no cores or too many; slack out of range; an app that needs what the planner cannot do; exact rates
// that cannot be met, with how much is missing.
Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request);

}  // namespace ctn::planner
