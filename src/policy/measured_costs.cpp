#include "policy/measured_costs.h"

#include <algorithm>

namespace ctn::policy {
namespace {

constexpr double kTypical = 50.0;  // percentile

}  // namespace

MeasuredCosts::MeasuredCosts(const graph::App& app, RunsThatCount count)
    : app_(app), batches_(app.graph), worked_(app.graph.nodes().size()) {
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    nodes_.emplace_back(app, NodeId(index), count);
    outputs_.emplace_back(app.graph, NodeId(index));
  }
}

bool MeasuredCosts::counts(NodeId id, bool idle) {
  if (app_.graph.node(id).input == graph::InputKind::kQueue) return true;
  const bool worked = worked_[id.index()];
  if (idle) return !worked;
  if (!worked) nodes_[id.index()].forget();
  worked_[id.index()] = true;
  return true;
}

void MeasuredCosts::set_clock(NodeId node, const Ticks& ticks) {
  for (NodeOutputs& outputs : outputs_) outputs.set_clock(node, ticks);
}

void MeasuredCosts::rescale(std::size_t kind, double factor) {
  for (NodeCosts& node : nodes_) node.rescale(kind, factor);
}

void MeasuredCosts::invalidate(std::size_t kind) {
  for (NodeCosts& node : nodes_) node.invalidate(kind);
}

std::vector<NodeId> MeasuredCosts::unknown() const {
  std::vector<NodeId> unknown;
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    if (app_.graph.nodes()[index].subchain && !nodes_[index].measured()) unknown.emplace_back(index);
  }
  return unknown;
}

std::size_t MeasuredCosts::known() const {
  const auto scheduled = [](const graph::Node& node) { return node.subchain.has_value(); };
  const auto all = std::count_if(app_.graph.nodes().begin(), app_.graph.nodes().end(), scheduled);
  return static_cast<std::size_t>(all) - unknown().size();
}

std::size_t MeasuredCosts::min_runs() const {
  std::size_t min = 0;
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    if (!app_.graph.nodes()[index].subchain || !nodes_[index].measured()) continue;
    min = min == 0 ? nodes_[index].count() : std::min(min, nodes_[index].count());
  }
  return min;
}

trial::MeasuredRuns MeasuredCosts::runs() const {
  trial::MeasuredRuns runs;
  for (const NodeCosts& node : nodes_) runs.push_back(node.runs());
  return runs;
}

model::CostTable MeasuredCosts::typical_costs(Millis unmeasured) const { return costs_at(kTypical, unmeasured); }

model::CostTable MeasuredCosts::costs_at(double percentile, Millis unmeasured) const {
  model::CostTable table = model::CostTable::assumed(app_.graph, unmeasured);
  for (const NodeCosts& node : nodes_) node.put_into(table, percentile);
  for (std::size_t index = 0; index < outputs_.size(); ++index) {
    table.set_idle(NodeId(index), outputs_[index].idle());
    if (app_.graph.nodes()[index].output_period) continue;
    table.set_runs_per_output(NodeId(index), outputs_[index].runs_per_output());
  }
  return table;
}

}  // namespace ctn::policy
