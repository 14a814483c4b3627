// Plans of periods and fixed priorities, which the methods that Catan is compared with make: as tables for people and
// as JSON for programs (docs/plan-schema.md).
#pragma once

#include <string>

#include "baselines/rate_plan.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::tool {

// `catans` is Catan's own plan for the same app, costs and cores; may be null.
std::string rate_plan_text(const baselines::RatePlan& plan, const graph::App& app, const plan::Plan* catans);
std::string rate_plan_json(const baselines::RatePlan& plan, const graph::App& app, const plan::Plan* catans);

}  // namespace ctn::tool
