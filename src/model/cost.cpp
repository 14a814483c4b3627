#include "model/cost.h"

#include <algorithm>
#include <cassert>
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
  profile.knows_all_ = true;
  return profile;
}

CostProfile CostProfile::with_measured(std::map<int, Millis> elapsed) const {
  assert(!knows_all_ && (elapsed.empty() || elapsed.begin()->first > 1));
  CostProfile profile = *this;
  profile.by_threads_ = std::move(elapsed);
  return profile;
}

CostProfile CostProfile::with_per_item(Millis per_item) const {
  assert(per_item >= Millis{0});
  CostProfile profile = *this;
  profile.per_item_ = per_item;
  return profile;
}

CostProfile CostProfile::with_items(double items) const {
  assert(items >= 0.0);
  CostProfile profile = *this;
  profile.per_item_ = Millis{0};
  const Millis more = per_item_ * items;
  const Millis alone = single_thread();
  for (ModeCost& mode : profile.modes_) mode.cost += more;
  for (auto& [threads, elapsed] : profile.by_threads_) elapsed += alone > Millis{0} ? more * (elapsed / alone) : more;
  return profile;
}

Millis CostProfile::single_thread() const {
  Millis sum{0};
  for (const ModeCost& mode : modes_) sum += mode.probability * mode.cost;
  return sum;
}

Millis CostProfile::with_threads(int q, int max_threads) const {
  assert(q >= 1 && max_threads >= 1);
  if (knows_all_) return std::prev(by_threads_.upper_bound(q))->second;
  const int threads = std::min(q, max_threads);
  const auto measured = by_threads_.find(threads);
  return measured != by_threads_.end() ? measured->second : single_thread() / threads;
}

int CostProfile::threads_used(int q) const {
  assert(q >= 1);
  return knows_all_ ? std::prev(by_threads_.upper_bound(q))->first : q;
}

int CostProfile::max_useful_threads(int max_threads) const {
  assert(max_threads >= 1);
  return knows_all_ ? by_threads_.rbegin()->first : max_threads;
}

CostProfile CostProfile::times(double factor) const {
  assert(factor >= 0.0);
  CostProfile scaled = *this;
  for (ModeCost& mode : scaled.modes_) mode.cost *= factor;
  for (auto& [threads, elapsed] : scaled.by_threads_) elapsed *= factor;
  scaled.per_item_ *= factor;
  return scaled;
}

CostTable::CostTable(const graph::Graph& graph, Millis initial)
    : waits_(graph.nodes().size(), Millis{0}),
      runs_per_output_(graph.nodes().size(), 1.0),
      idle_(graph.nodes().size()) {
  profiles_.reserve(graph.nodes().size());
  for (const graph::Node& node : graph.nodes()) {
    profiles_.push_back(CostProfile::constant(node.external ? Millis{0} : initial));
  }
}

CostTable CostTable::assumed(const graph::Graph& graph, Millis cost) {
  CostTable table(graph, Millis{0});
  for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
    if (!graph.nodes()[i].external) table.profiles_[i] = CostProfile::assumed(cost);
  }
  return table;
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

bool CostTable::has_batches(NodeId node) const {
  if ((*this)[node].per_item() > Millis{0}) return true;
  return std::any_of(on_kind_.begin(), on_kind_.end(), [&](const auto& given) {
    return given.first.first == node && given.second.per_item() > Millis{0};
  });
}

bool CostTable::has_batches() const {
  for (std::size_t i = 0; i < profiles_.size(); ++i) {
    if (has_batches(NodeId(i))) return true;
  }
  return false;
}

CostTable CostTable::with_items(std::span<const double> items) const {
  assert(items.size() == profiles_.size());
  CostTable table = *this;
  for (std::size_t i = 0; i < profiles_.size(); ++i) table.profiles_[i] = profiles_[i].with_items(items[i]);
  for (auto& [key, profile] : table.on_kind_) profile = profile.with_items(items[key.first.index()]);
  return table;
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

int CostTable::max_useful_threads(const graph::Graph& graph, SubchainId subchain) const {
  int max = 1;
  for (const NodeId node : graph.subchain(subchain).nodes) {
    max = std::max(max, (*this)[node].max_useful_threads(graph.node(node).max_threads));
  }
  return max;
}

Millis CostTable::subchain_wait(const graph::Graph& graph, SubchainId subchain) const {
  Millis sum{0};
  for (const NodeId node : graph.subchain(subchain).nodes) sum += wait(node);
  return sum;
}

}  // namespace ctn::model
