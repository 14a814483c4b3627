#include "model/cost.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>

namespace ctn::model {

CostProfile CostProfile::constant(Millis cost) {
  CostProfile profile;
  profile.modes_.front().cost = cost;
  return profile;
}

CostProfile CostProfile::of_modes(std::vector<ModeCost> modes) {
  assert(!modes.empty());
  CostProfile profile;
  profile.modes_ = std::move(modes);
  return profile;
}

CostProfile CostProfile::of_threads(std::map<int, Millis> elapsed) {
  assert(!elapsed.empty() && elapsed.begin()->first == 1);
  CostProfile profile = constant(elapsed.begin()->second);
  profile.by_threads_ = std::move(elapsed);
  return profile;
}

Millis CostProfile::single_thread() const {
  Millis sum{0};
  for (const ModeCost& mode : modes_) sum += mode.probability * mode.cost;
  return sum;
}

Millis CostProfile::with_threads(int q, int max_threads) const {
  assert(q >= 1 && max_threads >= 1);
  if (by_threads_.empty()) return single_thread() / std::min(q, max_threads);
  return std::prev(by_threads_.upper_bound(q))->second;
}

int CostProfile::threads_used(int q) const {
  assert(q >= 1);
  return by_threads_.empty() ? q : std::prev(by_threads_.upper_bound(q))->first;
}

CostProfile CostProfile::times(double factor) const {
  assert(factor >= 0.0);
  CostProfile scaled = *this;
  for (ModeCost& mode : scaled.modes_) mode.cost *= factor;
  for (auto& [threads, elapsed] : scaled.by_threads_) elapsed *= factor;
  return scaled;
}

CostTable::CostTable(const graph::Graph& graph, Millis initial)
    : waits_(graph.nodes().size(), Millis{0}), runs_per_output_(graph.nodes().size(), 1.0) {
  profiles_.reserve(graph.nodes().size());
  for (const graph::Node& node : graph.nodes()) {
    profiles_.push_back(CostProfile::constant(node.external ? Millis{0} : initial));
  }
}

CostTable CostTable::on(const graph::App& app, std::size_t kind) const {
  assert(kind < app.kinds());
  CostTable table = *this;
  table.on_kind_.clear();
  if (app.core_kinds.empty()) return table;
  for (std::size_t i = 0; i < profiles_.size(); ++i) {
    const auto given = on_kind_.find({NodeId(i), kind});
    table.profiles_[i] = given != on_kind_.end() ? given->second : profiles_[i].times(1.0 / app.core_kinds[kind].speed);
  }
  return table;
}

double CostTable::runs_per_output(const graph::Subchain& subchain, NodeId last) const {
  double runs = 1.0;
  for (const NodeId node : subchain.nodes) {
    runs *= runs_per_output(node);
    if (node == last) break;
  }
  return runs;
}

CostTable CostTable::without_waits() const {
  CostTable table = *this;
  table.waits_.assign(waits_.size(), Millis{0});
  return table;
}

std::vector<CostTable> costs_by_kind(const graph::App& app, const CostTable& costs) {
  std::vector<CostTable> tables;
  for (std::size_t kind = 0; kind < app.kinds(); ++kind) tables.push_back(costs.on(app, kind));
  return tables;
}

Millis CostTable::subchain_total(const graph::Graph& graph, SubchainId subchain) const {
  Millis sum{0};
  for (const NodeId node : graph.subchain(subchain).nodes) sum += (*this)[node].single_thread();
  return sum;
}

Millis CostTable::subchain_wait(const graph::Graph& graph, SubchainId subchain) const {
  Millis sum{0};
  for (const NodeId node : graph.subchain(subchain).nodes) sum += wait(node);
  return sum;
}

}  // namespace ctn::model
