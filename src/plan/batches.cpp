#include "plan/batches.h"

#include <algorithm>
#include <cmath>

#include "model/batches.h"
#include "plan/promise.h"

namespace ctn::plan {
namespace {

// Batches grow as needed in so many rounds, then by a quarter at least, and then to twice as many.
constexpr int kExactRounds = 4;
constexpr int kSmallSteps = 8;

Millis longest_window(const Plan& plan, const graph::App& app, NodeId id) {
  const graph::Node& node = app.graph.node(id);
  if (!node.subchain) return to_millis(node.period.value_or(Nanos{0}));
  const SubchainPlan& planned = plan.subchains[node.subchain->index()];
  if (member_of(plan, *node.subchain) == nullptr) return longest_gap(plan.cores, planned).value_or(planned.period);
  return planned.period + std::max(planned.execution - planned.slice, Millis{0});
}

}  // namespace

model::CostTable at_batches(const model::CostTable& costs, const std::vector<Batch>& batches,
                            const graph::Graph& graph) {
  if (!costs.has_batches()) return costs;
  std::vector<double> items(graph.nodes().size(), 0.0);
  for (const Batch& batch : batches) {
    if (batch.node.index() < items.size()) items[batch.node.index()] = std::max(batch.items, 0);
  }
  return costs.with_items(items);
}

std::optional<std::vector<Batch>> needed_batches(const Plan& plan, const graph::App& app,
                                                 const model::CostTable& costs) {
  std::vector<Batch> needed;
  if (!costs.has_batches()) return needed;
  const std::optional<std::vector<Promise>> promises = promise(plan, app, costs);
  if (!promises) return std::nullopt;
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    const NodeId node(index);
    if (!costs.has_batches(node)) continue;
    const double items = model::max_items(model::batch_inputs(app.graph, costs, node), longest_window(plan, app, node),
                                          [&](SubchainId id) { return (*promises)[id.index()].spacing; });
    needed.push_back({node, static_cast<int>(items)});
  }
  return needed;
}

std::vector<Batch> first_batches(const graph::Graph& graph, const model::CostTable& costs) {
  std::vector<Batch> batches;
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const NodeId node(index);
    if (!costs.has_batches(node)) continue;
    batches.push_back({node, static_cast<int>(model::batch_inputs(graph, costs, node).size())});
  }
  return batches;
}

bool enlarge(std::vector<Batch>& batches, const std::vector<Batch>& needed, int round) {
  bool enlarged = false;
  for (std::size_t i = 0; i < batches.size(); ++i) {
    int& items = batches[i].items;
    if (needed[i].items <= items) continue;
    const double step = round < kExactRounds ? 1.0 : round < kSmallSteps ? 1.25 : 2.0;
    items = std::max(needed[i].items, static_cast<int>(std::ceil(step * items)));
    enlarged = true;
  }
  return enlarged;
}

model::CostTable at_mean_batches(const Plan& plan, const graph::Graph& graph, const model::CostTable& costs) {
  if (!costs.has_batches()) return costs;
  const auto period_of = [&](SubchainId id) { return plan.subchains[id.index()].period; };
  std::vector<double> items(graph.nodes().size(), 0.0);
  for (std::size_t index = 0; index < items.size(); ++index) {
    const NodeId node(index);
    if (!costs.has_batches(node)) continue;
    const graph::Node& described = graph.node(node);
    const Millis window =
        described.subchain ? period_of(*described.subchain) : to_millis(described.period.value_or(Nanos{0}));
    items[index] = model::mean_items(model::batch_inputs(graph, costs, node), window, period_of);
  }
  return costs.with_items(items);
}

}  // namespace ctn::plan
