#include "model/unscheduled.h"

#include <algorithm>
#include <cstddef>
#include <optional>

namespace ctn::model {
namespace {

class ExclusiveWaits {
 public:
  ExclusiveWaits(const graph::App& app, std::span<const CostTable> by_kind, std::span<const int> cores)
      : app_(app), by_kind_(by_kind), cores_(cores) {
    for (const graph::ExclusiveGroup& group : app.exclusive) {
      if (std::any_of(group.nodes.begin(), group.nodes.end(), [&](NodeId node) { return unscheduled(node); })) {
        groups_.push_back(&group);
      }
    }
  }

  std::vector<Millis> run() const {
    std::vector<Millis> waits;
    if (groups_.empty()) return waits;
    waits.resize(app_.graph.nodes().size());
    for (const graph::ExclusiveGroup* const group : groups_) {
      Millis sum = longest_scheduled(*group) + raised_beside(*group);
      for (const NodeId node : group->nodes) sum += unscheduled(node) ? run_of(node) : Millis{0};
      for (const NodeId node : group->nodes) {
        if (unscheduled(node)) waits[node.index()] = sum - run_of(node);
      }
    }
    return waits;
  }

 private:
  bool unscheduled(NodeId node) const { return app_.graph.node(node).unscheduled; }
  int core_of(NodeId node) const { return cores_[app_.graph.node(node).subchain->index()]; }
  Millis run_of(NodeId node) const {
    const CostTable& costs = by_kind_[unscheduled(node) ? 0 : app_.kind_of(core_of(node))];
    return costs[node].single_thread() + costs.wait(node);
  }

  Millis longest_scheduled(const graph::ExclusiveGroup& group) const {
    Millis longest{0};
    for (const NodeId node : group.nodes) {
      if (!unscheduled(node)) longest = std::max(longest, run_of(node));
    }
    return longest;
  }

  bool may_hold_on(const graph::ExclusiveGroup& group, int core) const {
    return std::any_of(group.nodes.begin(), group.nodes.end(),
                       [&](NodeId node) { return !unscheduled(node) && core_of(node) == core; });
  }

  // Runs of other groups, on the cores of those of this one.
  Millis raised_beside(const graph::ExclusiveGroup& group) const {
    Millis sum{0};
    for (const graph::ExclusiveGroup* const other : groups_) {
      if (other == &group) continue;
      Millis longest{0};
      for (const NodeId node : other->nodes) {
        if (!unscheduled(node) && may_hold_on(group, core_of(node))) longest = std::max(longest, run_of(node));
      }
      sum += longest;
    }
    return sum;
  }

  const graph::App& app_;
  const std::span<const CostTable> by_kind_;
  const std::span<const int> cores_;
  std::vector<const graph::ExclusiveGroup*> groups_;  // that unscheduled nodes are in
};

}  // namespace

std::vector<Millis> exclusive_waits(const graph::App& app, std::span<const CostTable> by_kind,
                                    std::span<const int> cores) {
  return ExclusiveWaits(app, by_kind, cores).run();
}

Millis output_lateness(const graph::Graph& graph, const CostTable& costs, std::span<const Millis> waits, NodeId node,
                       double slack) {
  Millis late{0};
  for (std::optional<NodeId> at = node; at; at = graph.node(*at).follows) {
    late += (costs[*at].single_thread() + exclusive_wait_of(waits, *at)) / (1.0 - slack) + costs.wait(*at);
    if (graph.node(*at).output_period) late += to_millis(*graph.node(*at).period);
  }
  return late;
}

}  // namespace ctn::model
