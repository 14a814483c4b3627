// How old the data is that runs work on: the same afterwards, from what runs consumed, as live, where each output
// carries its *origin* (runtime/node_port.h, include/catan/channel.h).
//
// The origin of an output is the begin of the oldest source run that it goes back to. A source is a node that no other
// node feeds, external ones aside; the origin of its output is the begin of the run itself. The origin of any other is
// the oldest of those of the outputs that its run consumed. A run that consumed nothing works on what it had before:
// its output has the origin that the node's last run has found; and where no run has consumed anything yet, its own
// begin. What passes through an external node is not followed: it cannot be seen.
//
// The age of an input is the begin of the run minus the origin of what it consumed there, of a queue the oldest. Where
// it consumed nothing there, of what a run before it consumed last, which the node may still use; kNoAge: nothing ever.
// Below zero, since a source run began after the run that read it, is zero.
//
// Units: Nanos. Thread safety: none; one owner. Memory: the newest kHorizon runs of each node. What was forgotten, or
// never came, is taken to be as old as what the input had before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"

namespace ctn::record {

class AgeTracker {
 public:
  static constexpr std::size_t kHorizon = 8192;

  explicit AgeTracker(const graph::Graph& graph);

  // The ages of a run that has begun and says what it consumed.
  void set_ages(Run& run) const;
  // The next run has ended: sets its ages, and remembers it. Runs of one node in the order of their numbers, and a run
  // after those that it consumed. Nothing that comes is harmful. Returns the origin of its output.
  TimePoint add(Run& run);
  // The origin of what the node's run consumed last over an input.
  std::optional<TimePoint> taken(NodeId node, std::size_t input) const { return nodes_[node.index()].taken[input]; }
  // The origin of what a run consumes over an input, the oldest of the range; of what it took last, if no run in the
  // range is known to have given output.
  std::optional<TimePoint> origin(NodeId node, std::size_t input, std::uint64_t first, std::uint64_t last) const;

 private:
  struct Output {
    std::uint64_t number = 0;         // 0: none yet
    std::optional<TimePoint> origin;  // none: it gave no output
  };
  struct Node {
    std::vector<NodeId> predecessors;
    bool source = true;
    std::vector<Output> outputs;  // by number modulo kHorizon; grows as needed up to it
    std::uint64_t newest = 0;
    std::vector<std::optional<TimePoint>> taken;  // by predecessor
    std::optional<TimePoint> origin;              // found by its last run that consumed anything
  };

  static std::optional<TimePoint> oldest_output(const Node& node, std::uint64_t first, std::uint64_t last);
  std::optional<TimePoint> taken_by(const Run& run, std::size_t input, bool& consumed) const;

  std::vector<Node> nodes_;  // by NodeId
};

}  // namespace ctn::record
