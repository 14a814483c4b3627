// How many of one node's runs come to one output, as measured (model/output_estimator.h).
//
// What counts is what the node does with its inputs, so that it holds at any rate. A run without output tells nothing
// of that
//   - if it found nothing new in any input: how often it does depends on the nodes that feed it, and plans know that;
//   - if its input was stale and it had to skip (record/ages.h): that is the schedule's doing.
// Whether there is anything new from an external node is not known: with such an input all runs may count.
//
// Units: none. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "graph/app.h"
#include "model/output_estimator.h"
#include "record/events.h"

namespace ctn::policy {

class NodeOutputs {
 public:
  NodeOutputs(const graph::Graph& graph, NodeId node);

  // A run has ended; in their order.
  void add(const record::Run& run);

  double runs_per_output() const { return estimator_.runs_per_output(); }

 private:
  bool takes_new_input(const record::Run& run);
  bool had_to_skip(const record::Run& run) const;

  std::vector<std::optional<graph::AgeLimit>> limits_;  // by predecessor
  std::vector<NodeId> predecessors_;                    // empty: what a run finds is not known
  std::vector<std::uint64_t> taken_;                    // by predecessor: the newest run
  model::OutputEstimator estimator_;
};

}  // namespace ctn::policy
