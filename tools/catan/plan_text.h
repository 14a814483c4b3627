// A plan as tables, for people.
#pragma once

#include <string>

#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::tool {

// "each output of control", "every 2nd output of control".
std::string outputs_text(int every, const std::string& leader);

// What begins the runs of a subchain with a fixed priority: "every 20.000ms from 0.000ms".
std::string trigger_text(const plan::Member& member, const graph::App& app);

std::string plan_text(const plan::Plan& plan, const graph::App& app);

}  // namespace ctn::tool
