// The cost file (docs/cost-file.md): YAML text -> what runs cost, as strict as the app file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "model/workload.h"

namespace ctn::config {

// Every node that is neither external nor unscheduled must have a cost; unscheduled ones may (default 0).
Result<model::Workload> parse_workload(std::string_view text, std::string_view file, const graph::App& app);
Result<model::Workload> load_workload(const std::string& path, const graph::App& app);

// Where nodes may say themselves what their runs cost, the file need not name each: by NodeId, which it does.
struct PartialWorkload {
  model::Workload work;
  std::vector<bool> given;
};
Result<PartialWorkload> load_partial_workload(const std::string& path, const graph::App& app);

// What of it is planned with: the percentiles, without growth and spikes.
Result<model::CostTable> parse_costs(std::string_view text, std::string_view file, const graph::App& app);
Result<model::CostTable> load_costs(const std::string& path, const graph::App& app);

}  // namespace ctn::config
