// What runs cost, run by run: the law behind the percentiles that a planner sees. It comes from a cost file (config).
// `catan run --synthetic` burns what it draws.
//
// A run is in a mode, drawn by the modes' probabilities. What it costs is the mode's cost, or, where the file gives a
// typical cost too, log-normal: half of the mode's runs are below the typical cost, 95 % below the cost. That grows
// with the time since the start, linearly, and a spike comes on top with its own probability. In its middle it may
// wait, computing nothing; what it waits is drawn in the same way, and neither grows nor depends on the core. A run
// that takes a batch costs as much more for each item as the file says, no more and no less, and that grows, too.
//
// A draw depends on nothing but the seed, the node, the run's number and the time since the start: each caller gets
// the same answer, in any order, from any thread, on any machine (portable_math.h).
//
// Units: in the types. Thread safety: plain values, pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::model {

// No run is drawn longer than this, whatever the distribution's tail and the growth say.
constexpr Millis kLongestRun = std::chrono::hours{240};

struct Spikes {
  double probability = 0.0;  // that a run has one
  Millis extra{0};           // CPU time on top, in one thread
  friend bool operator==(const Spikes&, const Spikes&) = default;
};

// The law of one node's runs on one kind of cores.
struct NodeWork {
  CostProfile cost;                            // 95th percentiles at the start, without spikes: what is planned with
  std::vector<std::optional<Millis>> typical;  // medians by mode, 0 < typical <= cost; none: always the cost. Where
                                               // `cost` has times by threads: with one thread, the others in proportion
  double growth = 0.0;                         // a second, as a fraction of what a run cost at the start; >= 0
  Spikes spikes;

  static NodeWork constant(Millis cost) { return {CostProfile::constant(cost), {}, 0.0, {}}; }
  // On a core that takes `factor` times as long. Precondition: factor >= 0.
  NodeWork times(double factor) const;

  friend bool operator==(const NodeWork&, const NodeWork&) = default;
};

// In the middle of a node's runs, whichever core they are on.
struct WaitLaw {
  Millis wait{0};                 // 95th percentile: what is planned with
  std::optional<Millis> typical;  // median, 0 < typical <= wait; none: always the wait
  friend bool operator==(const WaitLaw&, const WaitLaw&) = default;
};

struct RunDraw {
  std::size_t mode = 0;  // index into the profile's modes, which are in the order of the app file's
  Nanos cpu{0};          // that each of the run's threads burns
  Nanos wait{0};         // of its first thread, after half of that
  Nanos per_item{0};     // that each of its threads burns for each item of its batch, beyond `cpu`

  // With a batch of so many items.
  Nanos cpu_with(std::size_t items) const;
  friend bool operator==(const RunDraw&, const RunDraw&) = default;
};

class Workload {
 public:
  // Nothing costs anything yet.
  explicit Workload(const graph::Graph& graph);

  const NodeWork& operator[](NodeId node) const { return nodes_[node.index()]; }
  void set(NodeId node, NodeWork work) { nodes_[node.index()] = std::move(work); }
  // On cores of one of the app's kinds; else it is what it is on one of speed 1, divided by speed.
  void set_on(NodeId node, std::size_t kind, NodeWork work) { on_kind_[{node, kind}] = std::move(work); }
  const WaitLaw& wait(NodeId node) const { return waits_[node.index()]; }
  void set_wait(NodeId node, WaitLaw wait) { waits_[node.index()] = wait; }
  // The work as it is on all cores of that kind. Precondition: kind < app.kinds().
  Workload on(const graph::App& app, std::size_t kind) const;

  // What is planned with: the percentiles, without growth and spikes.
  CostTable costs(const graph::Graph& graph) const;

  // Run `number` of a node, begun `since_start` after the start, on `threads` threads (>= 1; of more than the node's
  // max_threads, so many count). Its random draws are the same whatever `threads` and `since_start`.
  RunDraw draw(std::uint64_t seed, NodeId node, std::uint64_t number, Nanos since_start, int threads = 1) const;

 private:
  std::vector<NodeWork> nodes_;
  std::vector<WaitLaw> waits_;
  std::vector<int> max_threads_;
  std::map<std::pair<NodeId, std::size_t>, NodeWork> on_kind_;
};

}  // namespace ctn::model
