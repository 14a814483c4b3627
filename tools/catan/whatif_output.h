// What `catan whatif` shows: as text, as JSON (docs/whatif-schema.md), as a picture.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "sim/whatif.h"

namespace ctn::tool {

struct CoreLimit {
  int cores = 1;
  std::optional<double> min_speed;  // none: no speed is enough
};
struct NodeLimit {
  NodeId node;
  std::optional<double> max_factor;  // none: it does not fit at any cost
};

struct WhatIf {
  const graph::App& app;
  std::string scheduler;
  double seconds = 0.0;
  std::uint64_t seed = 0;
  std::vector<sim::Answer> hardware{};  // by cores, then speed
  std::vector<sim::Answer> nodes{};
  std::vector<sim::Answer> weights{};
  std::vector<CoreLimit> limits{};  // where the app has bounds and the scheduler plans
  std::vector<NodeLimit> node_limits{};
};

std::string whatif_text(const WhatIf& result);
std::string whatif_json(const WhatIf& result);
// Response times of the chain that weighs most, over speed, a line for each number of cores.
Result<std::string> whatif_svg(const WhatIf& result);

}  // namespace ctn::tool
