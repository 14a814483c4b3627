// From each subchain's period and execution time to what the developer asked about: the timing of a chain, the period
// of a node. The one place where chains are put together from subchains; the planner and the plan's check both use it.
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
#include "model/formulas.h"

namespace ctn::model {

struct SubchainTiming {
  Millis period{0};     // p
  Millis execution{0};  // L
  // From one trigger to the next, at most, where that is more than p: of a subchain that is triggered by outputs which
  // are late once and early the next time, or whose runs come in bursts.
  std::optional<Millis> longest_gap{};
  // Whose outputs trigger it, each or every so-many-th: a subchain, or an unscheduled node. It takes the one that does.
  std::optional<SubchainId> follows{};
  std::optional<NodeId> follows_node{};
  // Where it is triggered by time, and misses no trigger.
  struct ByPhase {
    Grid grid;
    std::optional<NodeId> clock;  // that the phase counts from; none: the system's
    int core = 0;
    int priority = 0;
    bool runs_through = true;  // it does not wait in the middle of its runs
  };
  std::optional<ByPhase> by_phase{};
};

// An element has the p and L of its subchain, even where the chain passes only some of its nodes; an unscheduled node
// has its own period, and its cost, its wait and what its exclusive group keeps it waiting, an external one that ticks
// the time between two ticks and no cost. An element that follows the element before adds L alone, and where that one
// is no follower itself, the outputs that it leaves out; one that keeps a phase to it, the wait that this comes to
// (InStep). What an unscheduled follower waits for otherwise is as late as the node that it follows may be.
// Preconditions: `subchains` is indexed by SubchainId; `path` is a chain of the graph with at least one node that is
// not external; `kept_waiting` is as unscheduled_waits() has it (unscheduled.h).
ChainTiming evaluate_chain(const graph::Graph& graph, std::span<const NodeId> path, const CostTable& costs,
                           std::span<const SubchainTiming> subchains, std::span<const Millis> kept_waiting = {});

// How often a node runs: its subchain's p, or an unscheduled node's own period. Not how often it emits: `output_period`
// has no part in it. Precondition: the node is not external.
Millis evaluate_period(const graph::Graph& graph, NodeId node, std::span<const SubchainTiming> subchains);

}  // namespace ctn::model
