// How many of one node's runs come to one output, as measured (model/output_estimator.h), and what runs are like that
// find nothing new (model/idle_estimator.h).
//
// What counts is what the node does with its inputs, so that it holds at any rate. A run without output tells nothing
// of that
//   - if it found nothing new in any input, and so was idle: how often it does depends on the nodes that feed it, and
//     plans know that;
//   - if its input was stale and it had to skip (record/ages.h): that is the schedule's doing.
// There is something new from an external node once its clock has ticked. Where it has none, or while it is not known,
// that cannot be told: with such an input all runs count.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/ticks.h"
#include "graph/app.h"
#include "model/idle_estimator.h"
#include "model/output_estimator.h"
#include "record/events.h"

namespace ctn::policy {

class NodeOutputs {
 public:
  NodeOutputs(const graph::Graph& graph, NodeId node);

  // A run has ended; in their order. Whether it was idle.
  bool add(const record::Run& run);
  // When that input ticks is known, from now on.
  void set_clock(NodeId input, const Ticks& ticks);

  double runs_per_output() const { return estimator_.runs_per_output(); }
  model::IdleRuns idle() const { return idle_.idle(); }

 private:
  struct Input {
    NodeId from;
    std::optional<graph::AgeLimit> limit;
    bool external = false;
    Ticks clock{};            // of an external one; without a period: it is not known
    std::uint64_t taken = 0;  // the newest run
  };

  bool takes_new_input(const record::Run& run);
  bool had_to_skip(const record::Run& run) const;

  std::vector<Input> inputs_;  // in the order of the node's predecessors
  std::optional<TimePoint> last_begin_;
  model::OutputEstimator estimator_;
  model::IdleEstimator idle_;
};

}  // namespace ctn::policy
