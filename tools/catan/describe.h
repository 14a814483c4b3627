// An app as Catan understood it, for people, for programs, and as a picture.
#pragma once

#include <string>

#include "graph/app.h"
#include "model/cost.h"

namespace ctn::tool {

// `costs` may be null: then they are not shown.
std::string describe_text(const graph::App& app, const model::CostTable* costs);
std::string describe_json(const graph::App& app, const model::CostTable* costs);
// For Graphviz: a box a subchain, bold edges where one node triggers the next.
std::string describe_dot(const graph::App& app, const model::CostTable* costs);

}  // namespace ctn::tool
