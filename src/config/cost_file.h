// The cost file (docs/cost-file.md): YAML text -> compute-time profiles, as strict as the app file.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::config {

// Every node that is neither external nor unscheduled must have a cost; unscheduled ones may (default 0).
Result<model::CostTable> parse_costs(std::string_view text, std::string_view file, const graph::App& app);
Result<model::CostTable> load_costs(const std::string& path, const graph::App& app);

}  // namespace ctn::config
