// Plans as JSON, both ways; the schema is in docs/plan-schema.md.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::plan {

// Of what to_json() writes. from_json() reads version 1 too, which has no "version", and whose cores have no "form".
constexpr int kJsonVersion = 2;

// One JSON document, indented by one space, numbers such that reading them back gives the same bits.
std::string to_json(const Plan& plan, const graph::App& app);

// The inverse. `file` names the text in errors (kCaller): what is missing, of the wrong type, or names what the app has
// not. The plan is well formed but not validated.
Result<Plan> from_json(std::string_view text, const graph::App& app, std::string_view file);

}  // namespace ctn::plan
