// Any bytes as a cost file for a fixed app: costs, none of them negative, or errors that say where.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "config/app_file.h"
#include "config/cost_file.h"

namespace {

constexpr std::string_view kApp = R"(catan: 1
app: demo
nodes:
  a: { max_threads: 4 }
  b: { modes: [x, y] }
  u: { unscheduled: true, period: 5ms }
  e: { external: true }
edges:
  - a -> b -> e
  - u -> a
objective:
  - { response_time: [a, b], weight: 1 }
)";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto app = ctn::config::parse_app(kApp, "app.yaml");
  if (!app.ok()) std::abort();
  const auto costs = ctn::config::parse_costs({reinterpret_cast<const char*>(data), size}, "fuzz.yaml", *app);
  if (costs.ok()) {
    for (std::size_t node = 0; node < app->graph.nodes().size(); ++node) {
      const double cost = (*costs)[ctn::NodeId(node)].single_thread().count();
      if (!std::isfinite(cost) || cost < 0.0) std::abort();
    }
    return 0;
  }
  for (const auto& problem : costs.error().problems()) {
    if (problem.place.line < 1 || problem.place.column < 1 || problem.what.empty() || problem.mend.empty())
      std::abort();
  }
  return 0;
}
