// What unscheduled nodes may be kept from, at worst: they are above all that is scheduled, but wait for their exclusive
// groups like all others.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include <span>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::model {

// For how long a run of each unscheduled node may wait for its exclusive group, by NodeId; 0 of all other nodes, and
// empty where no unscheduled node is in a group. One run of a scheduled node may have begun before, and is raised above
// all that is scheduled. It is not alone there: on its core a run of each other exclusive group that an unscheduled
// node waits for may be raised, too. Of each group the longest run counts. And each other unscheduled node of its own
// group may be before it, once. `by_kind`: costs_by_kind(); `cores`: one of each subchain, by SubchainId.
std::vector<Millis> exclusive_waits(const graph::App& app, std::span<const CostTable> by_kind,
                                    std::span<const int> cores);

// Of one node, where `waits` are exclusive_waits().
inline Millis exclusive_wait_of(std::span<const Millis> waits, NodeId node) {
  return waits.empty() ? Millis{0} : waits[node.index()];
}

// How late an output of an unscheduled node may be: its own run, and those of the nodes that it follows, with all that
// they wait for; and where one has an `output_period`, a period, since that ends between two runs. `costs`: on cores of
// the first kind; `waits`: exclusive_waits().
Millis output_lateness(const graph::Graph& graph, const CostTable& costs, std::span<const Millis> waits, NodeId node,
                       double slack);

}  // namespace ctn::model
