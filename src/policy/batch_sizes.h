// How many items the batch of each run of a queue node had: outputs of predecessors that it consumed. A run says only
// from which run to which, of which not all must have given an output.
//
// Units: none. Memory: 8 bytes an output that waits. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "graph/app.h"
#include "record/events.h"

namespace ctn::policy {

class BatchSizes {
 public:
  explicit BatchSizes(const graph::Graph& graph);

  // Of a run that has consumed its inputs; 0 where its node is no queue node. Once for each run, in their order.
  std::size_t taken_by(const record::Run& run);
  // A run has ended; after those that it consumed.
  void ended(const record::Run& run);

 private:
  struct Queue {
    NodeId from;
    std::deque<std::uint64_t> waiting;  // runs that gave an output
  };
  struct Output {
    std::size_t node = 0;
    std::size_t queue = 0;
  };
  std::vector<std::vector<Queue>> queues_;    // by node that takes from them
  std::vector<std::vector<Output>> outputs_;  // by node that feeds them
};

}  // namespace ctn::policy
