// How many items runs of a queue node find, by how often it and its predecessors run: what a run costs whose items cost
// something (cost.h) follows from it. Outputs of external nodes are not known, and no items.
//
//   on average   the time between two runs / the time between two outputs, for each predecessor
//   at most      one more than that, rounded up: each output may come a little later than usual, and no more than by
//                the time between two
//
// A predecessor in the node's own subchain gives each run just one. No queue holds more than kMaxItems.
//
// Units: Millis. Thread safety: plain values, pure functions.
#pragma once

#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::model {

// As a queue channel's capacity (catan/channel.h).
constexpr double kMaxItems = 4096.0;

// A predecessor of a queue node.
struct BatchInput {
  std::optional<SubchainId> subchain;  // whose runs give the items; none: an unscheduled node
  bool one_a_run = false;              // it is in the same subchain
  Millis apart{0};                     // two outputs of an unscheduled node that gives one in each run
  Millis output_period{0};             // of a subchain: no two outputs are closer together
  double runs_per_output = 1.0;

  // Within that time, where the subchain's runs are so far apart: the mean of both, or both at worst (the longest
  // window; runs as close together as they come on average over many).
  double mean_items(Millis window, Millis runs_apart) const;
  double max_items(Millis window, Millis runs_apart) const;
};

// Precondition: the node is no external one.
std::vector<BatchInput> batch_inputs(const graph::Graph& graph, const CostTable& costs, NodeId node);

// Of a node whose runs are `window` apart: `runs_apart` says so of subchains.
template <class RunsApart>
double mean_items(const std::vector<BatchInput>& inputs, Millis window, const RunsApart& runs_apart) {
  double items = 0.0;
  for (const BatchInput& input : inputs) {
    items += input.mean_items(window, input.subchain ? runs_apart(*input.subchain) : Millis{0});
  }
  return items;
}
template <class RunsApart>
double max_items(const std::vector<BatchInput>& inputs, Millis window, const RunsApart& runs_apart) {
  double items = 0.0;
  for (const BatchInput& input : inputs) {
    items += input.max_items(window, input.subchain ? runs_apart(*input.subchain) : Millis{0});
  }
  return items;
}

}  // namespace ctn::model
