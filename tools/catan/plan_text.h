// A plan as tables, for people.
#pragma once

#include <string>

#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::tool {

std::string plan_text(const plan::Plan& plan, const graph::App& app);

}  // namespace ctn::tool
