// Compute-time profiles: what one run of each node costs, as a value that the planner reads. They come from a cost file
// (config), from measurements (estimator.h), or, until measured, from `bootstrap_cost`. A node whose cost depends on
// what it finds to do has modes, each with its own cost; one that runs on several cores may have a time for each number
// of threads, all of them known beforehand or some of them measured. A run of a queue node, which takes a batch, may
// cost more with each item (an output of a predecessor) of it; how many these are depends on how often it and its
// predecessors run, so it is told apart from the cost. Beside its cost a run may have a wait: time in its middle in
// which the node computes nothing, for an accelerator, a device, a file. A wait adds to latency and never to load, and
// is no shorter on a faster core. And not every run must give an output, which makes chains through the node slower
// than it runs.
//
// Units: Millis for one run; of CPU time, all threads of the node added up, and of waits. Thread safety: plain values.
#pragma once

#include <compare>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::model {

// What one run took.
struct RunTime {
  Nanos cpu{0};   // all threads of the node added up
  Nanos wait{0};  // in which the node computed nothing
  friend auto operator<=>(const RunTime&, const RunTime&) = default;
};

struct ModeCost {
  std::string name;          // empty: the node has but one mode
  double probability = 1.0;  // in [0, 1]; those of a node add up to 1
  Millis cost{0};            // percentile of this mode's runs

  friend bool operator==(const ModeCost&, const ModeCost&) = default;
};

class CostProfile {
 public:
  CostProfile() = default;
  static CostProfile constant(Millis cost);
  // On any number of threads.
  static CostProfile assumed(Millis cost) { return of_threads({{1, cost}}); }
  // Precondition: not empty, probabilities add up to 1.
  static CostProfile of_modes(std::vector<ModeCost> modes);
  // Key: number of threads, >= 1; must hold 1. Value: elapsed time of a run with that many threads.
  static CostProfile of_threads(std::map<int, Millis> elapsed);

  // The same, where runs with so many threads (> 1) were measured to take so long. For numbers of threads that are not
  // there, times stay what they are without any: perfect scaling.
  CostProfile with_measured(std::map<int, Millis> elapsed) const;

  // The same, where each item of a batch adds so much (>= 0) to a run on one thread, and in proportion on several. All
  // else that a profile says is of runs without an item.
  CostProfile with_per_item(Millis per_item) const;
  Millis per_item() const { return per_item_; }
  // What runs with so many items cost (>= 0, a mean maybe), whatever they then have: per_item() is 0.
  CostProfile with_items(double items) const;

  // c: the probability-weighted sum of the modes' percentiles (docs/planner.md; paper section 5.3).
  Millis single_thread() const;
  // c^q: the time one run takes with at most q threads. Of of_threads(): that for the largest number of threads <= q.
  // Else as measured for min(q, max_threads), or single_thread() / min(q, max_threads). Precondition: q >= 1,
  // max_threads >= 1.
  Millis with_threads(int q, int max_threads) const;

  // How many of at most q threads a run makes use of: of of_threads(), the number that with_threads() goes by.
  // Precondition: q >= 1.
  int threads_used(int q) const;
  // More threads than this change nothing. Precondition: max_threads >= 1.
  int max_useful_threads(int max_threads) const;

  // The same, all times multiplied. Precondition: factor >= 0.
  CostProfile times(double factor) const;

  const std::vector<ModeCost>& modes() const { return modes_; }
  const std::map<int, Millis>& by_threads() const { return by_threads_; }

  friend bool operator==(const CostProfile&, const CostProfile&) = default;

 private:
  std::vector<ModeCost> modes_{ModeCost{}};
  std::map<int, Millis> by_threads_;
  bool knows_all_ = false;  // by_threads_ says what any number of threads takes
  Millis per_item_{0};
};

// What a node does in runs that find nothing new in any of its inputs, as measured.
struct IdleRuns {
  double part = 0.0;  // of these that are idle, in [0, 1]: they give no output. The others are like all runs
  Millis cost{0};     // CPU time of an idle run, on average
  friend bool operator==(const IdleRuns&, const IdleRuns&) = default;
};

// One profile a node, indexed by NodeId: what it costs on a core of speed 1, which is every core where the app says
// nothing of them. External nodes cost nothing.
class CostTable {
 public:
  // Every node that is not external costs `initial`, unscheduled ones too.
  CostTable(const graph::Graph& graph, Millis initial);
  // The same, on any number of threads: what is planned with before nodes have run, so that each runs on one thread
  // first, and it becomes known what it costs there.
  static CostTable assumed(const graph::Graph& graph, Millis cost);

  const CostProfile& operator[](NodeId node) const { return profiles_[node.index()]; }
  void set(NodeId node, CostProfile profile) { profiles_[node.index()] = std::move(profile); }

  // What a node costs on cores of one of the app's kinds; else it is what it costs on one of speed 1, divided by speed.
  void set_on(NodeId node, std::size_t kind, CostProfile profile) { on_kind_[{node, kind}] = std::move(profile); }
  // What all nodes cost on cores of that kind, by itself. Precondition: kind < app.kinds().
  CostTable on(const graph::App& app, std::size_t kind) const;

  // What a run waits, at the same percentile as the cost; 0 where nothing was set.
  Millis wait(NodeId node) const { return waits_[node.index()]; }
  void set_wait(NodeId node, Millis wait) { waits_[node.index()] = wait; }

  // How many runs of a node come to one output, on average, as measured: >= 1, and 1 where nothing was set. Of a node
  // whose `output_period` the app file gives, that counts.
  double runs_per_output(NodeId node) const { return runs_per_output_[node.index()]; }
  void set_runs_per_output(NodeId node, double runs) { runs_per_output_[node.index()] = runs; }
  // How many of the subchain's runs come to one output of its node `last`: no node runs before the one before it has
  // given an output. Precondition: `last` is one of its nodes.
  double runs_per_output(const graph::Subchain& subchain, NodeId last) const;

  // What it does where it finds nothing new; nothing is known where nothing was set. All else that the table says of a
  // node is of the runs that are not idle.
  IdleRuns idle(NodeId node) const { return idle_[node.index()]; }
  void set_idle(NodeId node, IdleRuns idle) { idle_[node.index()] = idle; }

  // Whether runs of any node, or of that one on some kind of cores, cost more with each item of a batch.
  bool has_batches() const;
  bool has_batches(NodeId node) const;
  // The same costs, where runs have so many items, by NodeId: none of them depends on batches any more.
  CostTable with_items(std::span<const double> items) const;

  // The same costs, where no run waits.
  CostTable without_waits() const;

  // C_i: the sum of single_thread() over the subchain's nodes.
  Millis subchain_total(const graph::Graph& graph, SubchainId subchain) const;
  // More threads than this change nothing for any of its nodes.
  int max_useful_threads(const graph::Graph& graph, SubchainId subchain) const;
  // W_i: what they wait.
  Millis subchain_wait(const graph::Graph& graph, SubchainId subchain) const;

 private:
  std::vector<CostProfile> profiles_;
  std::vector<Millis> waits_;            // by NodeId
  std::vector<double> runs_per_output_;  // by NodeId
  std::vector<IdleRuns> idle_;           // by NodeId
  std::map<std::pair<NodeId, std::size_t>, CostProfile> on_kind_;
};

// `costs` on each of the app's kinds of cores; one table where all are alike.
std::vector<CostTable> costs_by_kind(const graph::App& app, const CostTable& costs);

}  // namespace ctn::model
