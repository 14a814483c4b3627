#include "baselines/reservations.h"

#include <algorithm>

namespace ctn::baselines {
namespace {

// Longest over the kinds of cores that there are some of.
Millis cost_of(const graph::App& app, const std::vector<model::CostTable>& by_kind, NodeId node, int cores) {
  const std::vector<int> counts = app.cores_by_kind(cores);
  Millis longest{0};
  for (std::size_t kind = 0; kind < by_kind.size(); ++kind) {
    if (counts[kind] > 0) longest = std::max(longest, by_kind[kind][node].single_thread());
  }
  return longest;
}

}  // namespace

Reservations reserve(const graph::App& app, const model::CostTable& costs, std::span<const Rate> rates, int cores,
                     const ReservationRules& rules) {
  const std::vector<model::CostTable> by_kind = model::costs_by_kind(app, costs);
  Reservations made;
  made.nodes.resize(app.graph.nodes().size());
  double tightest = 0.0;  // the largest part of a core that one thread asks for
  for (std::size_t index = 0; index < made.nodes.size(); ++index) {
    const graph::Node& node = app.graph.nodes()[index];
    if (!node.subchain) continue;
    const Millis runtime = rules.margin * cost_of(app, by_kind, NodeId(index), cores);
    made.nodes[index].runtime = std::max(rules.shortest, to_nanos(runtime));
    const double part = to_millis(made.nodes[index].runtime) / rates[node.subchain->index()].period();
    made.asked += part;
    tightest = std::max(tightest, part);
  }
  made.factor = std::max({1.0, made.asked / (rules.max_bandwidth * cores), tightest});
  made.admitted = made.factor <= 1.0;
  for (const Rate rate : rates) {
    // Rounded up, and a nanosecond more where it was lowered, so that the sum is within the limit.
    made.periods.push_back(to_nanos(rate.period() * made.factor) + Nanos{made.admitted ? 0 : 1});
  }
  for (std::size_t index = 0; index < made.nodes.size(); ++index) {
    const graph::Node& node = app.graph.nodes()[index];
    if (node.subchain) made.nodes[index].period = made.periods[node.subchain->index()];
  }
  return made;
}

}  // namespace ctn::baselines
