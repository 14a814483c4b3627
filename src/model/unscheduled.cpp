#include "model/unscheduled.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace ctn::model {
namespace {

// Whether it is that node, or follows it, directly or by others.
bool goes_back_to(const graph::Graph& graph, NodeId node, NodeId before) {
  std::optional<NodeId> at = node;
  while (at && *at != before) at = graph.node(*at).follows;
  return at.has_value();
}

class UnscheduledWaits {
 public:
  UnscheduledWaits(const graph::App& app, std::span<const CostTable> by_kind, std::span<const int> cores_of,
                   std::size_t cores)
      : app_(app), by_kind_(by_kind), cores_of_(cores_of), cores_(cores) {
    for (const graph::ExclusiveGroup& group : app.exclusive) {
      if (std::any_of(group.nodes.begin(), group.nodes.end(), [&](NodeId node) { return unscheduled(node); })) {
        groups_.push_back(&group);
      }
    }
    for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
      if (unscheduled(NodeId(i))) unscheduled_.emplace_back(i);
    }
  }

  std::vector<Millis> run() const {
    if (groups_.empty() && unscheduled_.size() < 2) return {};
    const std::vector<Millis> for_group = for_groups();
    std::vector<Millis> most = for_group;
    add_for_cores(most, {});
    std::vector<Millis> waits = for_group;
    add_for_cores(waits, most);
    return waits;
  }

 private:
  // Where there is a core for each, none waits, unless it comes back to one that another has taken meanwhile.
  double waits_for_core(NodeId node) const {
    const bool leaves = by_kind_.front().wait(node) > Millis{0} || app_.graph.node(node).exclusive;
    return (unscheduled_.size() > cores_ ? 1.0 : 0.0) + (leaves ? 1.0 : 0.0);
  }

  std::vector<Millis> for_groups() const {
    std::vector<Millis> waits(app_.graph.nodes().size());
    for (const graph::ExclusiveGroup* const group : groups_) {
      Millis sum = longest_scheduled(*group) + raised_beside(*group);
      for (const NodeId node : group->nodes) sum += unscheduled(node) ? run_of(node) : Millis{0};
      for (const NodeId node : group->nodes) {
        if (unscheduled(node)) waits[node.index()] = sum - run_of(node);
      }
    }
    return waits;
  }

  // `waits` that are known to hold: what they say of those that go back to one another.
  void add_for_cores(std::vector<Millis>& to, std::span<const Millis> waits) const {
    for (const NodeId node : unscheduled_) {
      for (const NodeId other : unscheduled_) {
        if (other != node && !(are_apart(node, other, waits)))
          to[node.index()] += waits_for_core(node) * cost_of(other);
      }
    }
  }

  // They go back to one another, and to a timer before whose next time both have ended.
  bool are_apart(NodeId one, NodeId other, std::span<const Millis> waits) const {
    if (waits.empty()) return false;
    const bool behind = goes_back_to(app_.graph, one, other);
    if (!behind && !goes_back_to(app_.graph, other, one)) return false;
    const NodeId last = behind ? one : other;
    NodeId first = last;
    while (app_.graph.node(first).follows) first = *app_.graph.node(first).follows;
    return output_lateness(app_.graph, by_kind_.front(), waits, last, 0.0) <= to_millis(*app_.graph.node(first).period);
  }

  Millis cost_of(NodeId node) const { return by_kind_.front()[node].single_thread(); }
  bool unscheduled(NodeId node) const { return app_.graph.node(node).unscheduled; }
  int core_of(NodeId node) const { return cores_of_[app_.graph.node(node).subchain->index()]; }
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
  const std::span<const int> cores_of_;
  const std::size_t cores_;
  std::vector<const graph::ExclusiveGroup*> groups_;  // that unscheduled nodes are in
  std::vector<NodeId> unscheduled_;
};

}  // namespace

std::vector<Millis> unscheduled_waits(const graph::App& app, std::span<const CostTable> by_kind,
                                      std::span<const int> cores_of, std::size_t cores) {
  return UnscheduledWaits(app, by_kind, cores_of, cores).run();
}

Millis output_lateness(const graph::Graph& graph, const CostTable& costs, std::span<const Millis> waits, NodeId node,
                       double slack) {
  Millis late{0};
  for (std::optional<NodeId> at = node; at; at = graph.node(*at).follows) {
    late += (costs[*at].single_thread() + unscheduled_wait_of(waits, *at)) / (1.0 - slack) + costs.wait(*at);
    if (graph.node(*at).output_period) late += to_millis(*graph.node(*at).period);
  }
  return late;
}

double UnscheduledLoad::runs_within(Millis window) const {
  constexpr double kNearlyWhole = 1e-9;
  return std::max(std::ceil((window + sooner) / apart - kNearlyWhole) - over, 0.0);
}

std::vector<UnscheduledLoad> unscheduled_loads(const graph::App& app, std::span<const CostTable> by_kind,
                                               std::span<const Millis> waits, SubchainId subchain, std::size_t kind,
                                               double slack, std::optional<NodeId> leader) {
  const std::vector<NodeId>& own = app.graph.subchain(subchain).nodes;
  std::vector<UnscheduledLoad> loads;
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    const graph::Node& node = app.graph.nodes()[i];
    if (!node.unscheduled) continue;
    const CostTable& costs = by_kind[kind];
    UnscheduledLoad load{.run = costs[NodeId(i)].single_thread() / (1.0 - slack), .apart = to_millis(*node.period)};
    load.sooner = output_lateness(app.graph, by_kind.front(), waits, NodeId(i), slack);
    const bool excluded = node.exclusive && std::any_of(own.begin(), own.end(), [&](NodeId each) {
                            return app.graph.node(each).exclusive == node.exclusive;
                          });
    // Of a run that it awaits all may be left; else what is late is what comes before its work, or between.
    if (!excluded) load.sooner = std::max(load.sooner - load.run, Millis{0});
    if (excluded) load.run += costs.wait(NodeId(i));
    if (leader && goes_back_to(app.graph, *leader, NodeId(i))) load.over = 1.0;
    if (load.run > Millis{0}) loads.push_back(load);
  }
  return loads;
}

}  // namespace ctn::model
