// Cores and fixed priorities in the manner of Choi, Xiang and Kim, "PiCAS: new design of priority-driven chain-aware
// scheduling for ROS2", RTAS 2021. Rates are given (set by hand).
//
// Chains are ranked by how critical they are: by their weight. All nodes of a more critical chain pre-empt all of a
// less critical one, and within a chain a later node pre-empts an earlier one, so that what is under way is finished
// before something new is begun. Chain by chain, subchains (which stand for executors) are put together on one core, as
// long as it has room for them; those of a chain that fit on no core together go one by one to the emptiest.
//
// What differs from the paper:
// - An executor is a subchain and a node has a thread of its own, so each node has a priority of its own, where the
//   paper has priorities of executors, and of callbacks within one.
// - A node in several chains belongs to the most critical of them. A period in the objective is a chain of its node's
//   subchain. What is in no chain comes last.
// - The paper merges executors where there are more than cores have room for, and bounds the latency of chains by
//   analysis; here a core may be given more than it can do, and nothing is promised.
//
// Units: in the types. Thread safety: plain values, pure functions.
#pragma once

#include <span>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::baselines {

struct ChainAware {
  std::vector<int> core;             // by SubchainId
  std::vector<int> rank;             // by NodeId: 0 the lowest, each once; -1: not scheduled
  std::vector<double> utilisations;  // by core

  friend bool operator==(const ChainAware&, const ChainAware&) = default;
};

// Preconditions: `rates` by SubchainId; cores >= 1, and no more than the app lists.
ChainAware assign_by_chains(const graph::App& app, const model::CostTable& costs, std::span<const Rate> rates,
                            int cores);

}  // namespace ctn::baselines
