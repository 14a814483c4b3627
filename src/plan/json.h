// Plans as JSON, both ways; the schema is in docs/plan-schema.md.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::plan {

// One JSON document, indented by one space, numbers such that reading them back gives the same bits.
std::string to_json(const Plan& plan, const graph::App& app);

// The inverse. `file` names the text in errors (kCaller): what is missing, of the wrong type, or names what the app has
// not. The plan is well formed but not validated.
Result<Plan> from_json(std::string_view text, const graph::App& app, std::string_view file);

}  // namespace ctn::plan
