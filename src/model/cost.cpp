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

CostTable::CostTable(const graph::Graph& graph, Millis initial) {
  profiles_.reserve(graph.nodes().size());
  for (const graph::Node& node : graph.nodes()) {
    profiles_.push_back(CostProfile::constant(node.external ? Millis{0} : initial));
  }
}

Millis CostTable::subchain_total(const graph::Graph& graph, SubchainId subchain) const {
  Millis sum{0};
  for (const NodeId node : graph.subchain(subchain).nodes) sum += (*this)[node].single_thread();
  return sum;
}

}  // namespace ctn::model
