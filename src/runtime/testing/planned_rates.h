// For tests: whether nodes ran at the rates of a plan.
#pragma once

#include <gtest/gtest.h>

#include "catan/snapshot.h"
#include "graph/app.h"

namespace ctn::runtime {

// Each node's rate is the planned one, but for `within` of it, for a run at either end, and for what a snapshot has not
// seen yet: runs are collected every 50 ms. `plan` has a period for each subchain, and each node is in a subchain.
template <class Plan>
void expect_planned_rates(const graph::App& app, const Snapshot& snapshot, const Plan& plan, double within = 0.0) {
  for (const NodeSnapshot& node : snapshot.nodes) {
    const SubchainId id = *app.graph.node(*app.graph.find_node(node.name)).subchain;
    const double planned = 1000.0 / plan.subchains[id.index()].period.count();
    const auto runs = static_cast<double>(node.compute_ms.count);
    EXPECT_GT(runs, 20.0) << node.name;
    EXPECT_NEAR(node.rate_hz / planned, 1.0, within + (1.5 + 0.05 * planned) / runs) << node.name;
  }
}

}  // namespace ctn::runtime
