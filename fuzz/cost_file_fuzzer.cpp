// Any bytes as a cost file for a fixed app: costs and draws, none of them negative, or errors that say where.
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
  q: { input: queue, max_threads: 2 }
  e: { external: true }
edges:
  - a -> b -> e
  - u -> a
  - b -> q
objective:
  - { response_time: [a, b], weight: 1 }
)";

void check_draws(const ctn::model::Workload& work, ctn::NodeId node, std::size_t modes) {
  for (std::uint64_t run = 1; run <= 20; ++run) {
    const ctn::model::RunDraw draw = work.draw(1, node, run, std::chrono::hours{run}, static_cast<int>(run % 4 + 1));
    if (draw.cpu < ctn::Nanos{0} || draw.cpu > ctn::to_nanos(ctn::model::kLongestRun)) std::abort();
    const ctn::Nanos with_batch = draw.cpu_with(run * run);
    if (with_batch < draw.cpu || with_batch > ctn::to_nanos(ctn::model::kLongestRun)) std::abort();
    if (draw.wait < ctn::Nanos{0} || draw.wait > ctn::to_nanos(ctn::model::kLongestRun)) std::abort();
    if (draw.mode >= (modes == 0 ? 1 : modes)) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto app = ctn::config::parse_app(kApp, "app.yaml");
  if (!app.ok()) std::abort();
  const auto work = ctn::config::parse_workload({reinterpret_cast<const char*>(data), size}, "fuzz.yaml", *app);
  if (work.ok()) {
    const ctn::model::CostTable costs = work->costs(app->graph);
    for (std::size_t index = 0; index < app->graph.nodes().size(); ++index) {
      const ctn::NodeId node(index);
      const double cost = costs[node].single_thread().count();
      if (!std::isfinite(cost) || cost < 0.0) std::abort();
      const double with_batch = costs[node].with_items(100.0).single_thread().count();
      if (!std::isfinite(with_batch) || with_batch < cost) std::abort();
      const double wait = costs.wait(node).count();
      if (!std::isfinite(wait) || wait < 0.0) std::abort();
      check_draws(*work, node, app->graph.node(node).modes.size());
    }
    return 0;
  }
  for (const auto& problem : work.error().problems()) {
    if (problem.place.line < 1 || problem.place.column < 1 || problem.what.empty() || problem.hint.empty())
      std::abort();
  }
  return 0;
}
