// Which runs each run consumed, for an observer. Kept apart from what a trial itself needs, and only if one is there.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "graph/app.h"
#include "trial/trial.h"

namespace ctn::trial {

class RunLog {
 public:
  // Both outlive it.
  RunLog(const graph::App& app, Observer& observer);

  void begin(NodeId node, TimePoint now);
  void end(NodeId node, TimePoint now, bool emitted);

 private:
  struct Input {
    NodeId predecessor;
    std::uint64_t taken = 0;    // the newest run consumed so far
    std::uint64_t newest = 0;   // output that is there
    std::uint64_t waiting = 0;  // in a queue
  };
  struct Output {
    NodeId node;
    std::size_t input = 0;
  };
  struct Node {
    bool queue = false;
    std::vector<Input> inputs;
    std::vector<Output> outputs;
    ObservedRun run;  // under way
  };

  Observer& observer_;
  std::vector<Node> nodes_;
};

}  // namespace ctn::trial
