#include "sim/recorded_costs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/mixed.h"

namespace ctn::sim {
Result<RecordedRuns> RecordedRuns::read(const record::Reader& record, const graph::App& app) {
  std::vector<std::optional<NodeId>> ours;  // by the record's nodes
  for (const graph::Node& node : record.app().graph.nodes()) ours.push_back(app.graph.find_node(node.name));
  RecordedRuns runs;
  runs.by_node.resize(app.graph.nodes().size());
  const Status read = record.each_run([&](const record::Run& run) {
    const std::optional<NodeId> node = ours[run.node.index()];
    if (!node) return;
    // Of a mode that the app does not know (any more), the first stands for it.
    const bool known = run.mode < std::max<std::size_t>(1, app.graph.node(*node).modes.size());
    runs.by_node[node->index()].push_back({run.cpu, known ? run.mode : 0, run.wait});
  });
  if (!read) return read.error();
  std::vector<Problem> problems;
  for (std::size_t index = 0; index < runs.by_node.size(); ++index) {
    const graph::Node& node = app.graph.nodes()[index];
    if (node.external || !runs.by_node[index].empty()) continue;
    problems.push_back({{},
                        {},
                        fmt::format("the record has no run of node {}", node.name),
                        "record a run of this app in which every node runs"});
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return runs;
}

RecordedCosts::RecordedCosts(const graph::App& app, std::shared_ptr<const RecordedRuns> runs, Order order,
                             std::uint64_t seed, Nanos overhead)
    : runs_(std::move(runs)), order_(order), seed_(seed), overhead_(overhead) {
  if (app.core_kinds.empty()) speeds_.push_back(1.0);
  for (const graph::CoreKind& kind : app.core_kinds) speeds_.push_back(kind.speed);
}

model::RunDraw RecordedCosts::draw(NodeId node, std::uint64_t number, Nanos, int threads, std::size_t kind) {
  const std::vector<RecordedRuns::Cost>& runs = runs_->by_node[node.index()];
  const std::uint64_t index = order_ == Order::kAsRecorded ? number - 1 : mixed_of(seed_, node.index(), number);
  const RecordedRuns::Cost& cost = runs[index % runs.size()];
  const Nanos share = std::max(cost.cpu / threads - overhead_, Nanos{0});
  return {cost.mode, Nanos{std::llround(static_cast<double>(share.count()) / speeds_[kind])}, cost.wait};
}

}  // namespace ctn::sim
