// Why a chain may be expected to take longer than it is promised (plan::chains_above_promise()).
//
// Thread safety: a pure function.
#pragma once

#include <string>

#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::plan {

// What promises leave out, of what the plan has: "no promise has in it what ...".
std::string why_above_promise(const Plan& plan, const graph::App& app);

}  // namespace ctn::plan
