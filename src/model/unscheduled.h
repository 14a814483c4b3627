// What unscheduled nodes may be kept from, and what they keep others from, at worst: they are above all that is
// scheduled, but wait for one another, and for their exclusive groups like all others.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::model {

// For how long a run of each unscheduled node may be kept waiting, by NodeId; 0 of all other nodes, and empty where
// none may.
//
// For its exclusive group: one run of a scheduled node may have begun before, and is raised above all that is
// scheduled. It is not alone there: on its core a run of each other exclusive group that an unscheduled node waits for
// may be raised, too. Of each group the longest run counts. And each other unscheduled node of its own group may be
// before it, once.
//
// For a core: where there are fewer than unscheduled nodes, one run of each other one may be before it, and where it
// comes back from a wait once more. Of a node and those that follow it, directly or by others, no two are under way
// together where all of them have ended before it runs again.
//
// `by_kind`: costs_by_kind(); `cores_of`: one core of each subchain, by SubchainId; `cores`: how many there are in all.
std::vector<Millis> unscheduled_waits(const graph::App& app, std::span<const CostTable> by_kind,
                                      std::span<const int> cores_of, std::size_t cores);

// Of one node, where `waits` are unscheduled_waits().
inline Millis unscheduled_wait_of(std::span<const Millis> waits, NodeId node) {
  return waits.empty() ? Millis{0} : waits[node.index()];
}

// How late an output of an unscheduled node may be: its own run, and those of the nodes that it follows, with all that
// they wait for; and where one has an `output_period`, a period, since that ends between two runs. `costs`: on cores of
// the first kind; `waits`: unscheduled_waits().
Millis output_lateness(const graph::Graph& graph, const CostTable& costs, std::span<const Millis> waits, NodeId node,
                       double slack);

// What runs of an unscheduled node take of those of a subchain: on its core, since they are above it, and where they
// have its exclusive group, whose runs it awaits.
struct UnscheduledLoad {
  Millis run{0};      // of the subchain's time
  Millis apart{0};    // from one run to the next, on average
  Millis sooner{0};   // and some come so much closer together
  double over = 0.0;  // so many have just ended when the run is triggered

  // At most, in any time that is so long.
  double runs_within(Millis window) const;
};

// Of all of them, on a run of the subchain on cores of that kind; by NodeId, without those that take nothing. `leader`:
// of these, at whose outputs it is triggered, right away; none: there is none.
std::vector<UnscheduledLoad> unscheduled_loads(const graph::App& app, std::span<const CostTable> by_kind,
                                               std::span<const Millis> waits, SubchainId subchain, std::size_t kind,
                                               double slack, std::optional<NodeId> leader);

}  // namespace ctn::model
