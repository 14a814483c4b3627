// What explains a plan, as text for people and as JSON.
#pragma once

#include <string>
#include <string_view>

#include "graph/app.h"
#include "plan/plan.h"
#include "planner/explain.h"

namespace ctn::tool {

std::string explain_text(const planner::Explanation& explanation, const plan::Plan& plan, const graph::App& app);

// The plan's document with the key "explanation" added.
std::string add_explanation(std::string_view plan_json, const planner::Explanation& explanation, const graph::App& app);

}  // namespace ctn::tool
