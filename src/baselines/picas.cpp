#include "baselines/picas.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace ctn::baselines {
namespace {

// The nodes of a chain that are scheduled, in order.
using Row = std::vector<NodeId>;

std::vector<Row> rows_by_weight(const graph::App& app) {
  std::vector<const graph::Term*> terms;
  for (const graph::Term& term : app.objective) terms.push_back(&term);
  std::stable_sort(terms.begin(), terms.end(),
                   [](const graph::Term* a, const graph::Term* b) { return a->weight > b->weight; });
  std::vector<Row> rows;
  for (const graph::Term* term : terms) {
    Row row;
    if (term->metric == graph::Metric::kPeriod) {
      if (const auto& subchain = app.graph.node(term->path.front()).subchain) row = app.graph.subchain(*subchain).nodes;
    } else {
      std::copy_if(term->path.begin(), term->path.end(), std::back_inserter(row),
                   [&](NodeId id) { return app.graph.node(id).subchain.has_value(); });
    }
    rows.push_back(std::move(row));
  }
  Row rest;
  for (const NodeId id : app.graph.topological_order()) {
    if (app.graph.node(id).subchain) rest.push_back(id);
  }
  rows.push_back(std::move(rest));
  return rows;
}

std::vector<int> ranks(const graph::App& app, const std::vector<Row>& rows) {
  std::vector<int> rank(app.graph.nodes().size(), -1);
  int next = -1;
  for (const graph::Node& node : app.graph.nodes()) next += node.subchain ? 1 : 0;
  for (const Row& row : rows) {
    for (auto id = row.rbegin(); id != row.rend(); ++id) {
      if (rank[id->index()] < 0) rank[id->index()] = next--;
    }
  }
  return rank;
}

class Placing {
 public:
  Placing(const graph::App& app, const model::CostTable& costs, std::span<const Rate> rates, int cores)
      : app_(app),
        costs_(model::costs_by_kind(app, costs)),
        rates_(rates),
        used_(static_cast<std::size_t>(cores), 0.0) {
    core_.assign(app.graph.subchains().size(), -1);
  }

  // The subchains of a row that have no core yet.
  void place(const Row& row) {
    std::vector<std::size_t> others;
    int home = -1;  // where the chain has most of itself already: the last found
    for (const NodeId id : row) {
      const std::size_t subchain = app_.graph.node(id).subchain->index();
      if (core_[subchain] >= 0) {
        home = core_[subchain];
      } else if (std::find(others.begin(), others.end(), subchain) == others.end()) {
        others.push_back(subchain);
      }
    }
    if (others.empty()) return;
    const int emptiest = static_cast<int>(std::min_element(used_.begin(), used_.end()) - used_.begin());
    for (const int core : {home, emptiest}) {
      if (core < 0 || used(core) + load(others, core) > 1.0) continue;
      for (const std::size_t subchain : others) put(subchain, core);
      return;
    }
    for (const std::size_t subchain : others) {
      put(subchain, static_cast<int>(std::min_element(used_.begin(), used_.end()) - used_.begin()));
    }
  }

  const std::vector<int>& core() const { return core_; }
  const std::vector<double>& utilisations() const { return used_; }

 private:
  double used(int core) const { return used_[static_cast<std::size_t>(core)]; }

  double load(std::size_t subchain, int core) const {
    return costs_[app_.kind_of(core)].subchain_total(app_.graph, SubchainId(subchain)) / rates_[subchain].period();
  }

  double load(const std::vector<std::size_t>& subchains, int core) const {
    return std::accumulate(subchains.begin(), subchains.end(), 0.0,
                           [&](double sum, std::size_t subchain) { return sum + load(subchain, core); });
  }

  void put(std::size_t subchain, int core) {
    core_[subchain] = core;
    used_[static_cast<std::size_t>(core)] += load(subchain, core);
  }

  const graph::App& app_;
  const std::vector<model::CostTable> costs_;  // by kind of cores
  std::span<const Rate> rates_;
  std::vector<double> used_;
  std::vector<int> core_;
};

}  // namespace

ChainAware assign_by_chains(const graph::App& app, const model::CostTable& costs, std::span<const Rate> rates,
                            int cores) {
  const std::vector<Row> rows = rows_by_weight(app);
  Placing placing(app, costs, rates, cores);
  for (const Row& row : rows) placing.place(row);
  return {placing.core(), ranks(app, rows), placing.utilisations()};
}

}  // namespace ctn::baselines
