// What runs cost in a trial (trial.h): for each node and kind of core a row of draws, made once and used by every
// trial. The k-th run of a node takes the k-th draw, whatever the schedule, so that two schedules that are compared
// have the same luck. What the items of a run's batch add comes on top: how many they are is the schedule's doing.
//
// Units: Nanos. Thread safety: immutable once made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "model/workload.h"

namespace ctn::trial {

// Runs as measured: by NodeId, then by the kind of core that they ran on. No node must have any.
using MeasuredRuns = std::vector<std::vector<std::vector<model::RunTime>>>;

class Samples {
 public:
  static constexpr std::size_t kDraws = 4096;  // of each node and kind; a power of two

  // Draws for runs that begin this long after the start: costs that grow with time are taken as they are then.
  Samples(const graph::App& app, const model::Workload& work, Nanos since_start, std::uint64_t seed);
  // Each draw is one of the node's measured runs. On a kind of core where it has not run, they are those of another,
  // in proportion to `costs`; a node that never ran costs what these say.
  Samples(const graph::App& app, const MeasuredRuns& measured, const model::CostTable& costs);

  // CPU time of a run on one thread without items, > 0. `number`: any; draws repeat after kDraws.
  Nanos draw(NodeId node, std::size_t kind, std::uint32_t number) const {
    return draws_[(node.index() * kinds_ + kind) * kDraws + number % kDraws];
  }

  // Of all its draws, in ms and ms squared.
  struct Moments {
    double mean = 0.0;
    double variance = 0.0;
  };
  Moments moments(NodeId node, std::size_t kind) const;

  // What each item of a batch adds.
  Millis per_item(NodeId node, std::size_t kind) const { return costs_[kind][node].per_item(); }
  Nanos of_items(NodeId node, std::size_t kind, std::size_t items) const;
  // Whether runs of the node, on any kind of core, cost more with each item.
  bool has_batches(NodeId node) const;

  // What the same run waits in its middle.
  Nanos wait(NodeId node, std::uint32_t number) const {
    return waits(node) ? waits_[node.index()][number % kDraws] : Nanos{0};
  }
  // Whether any run of the node waits; of any node.
  bool waits(NodeId node) const { return !waits_[node.index()].empty(); }
  bool any_waits() const;
  // Of all its runs.
  struct Waits {
    double mean = 0.0;  // ms
    double part = 0.0;  // of the runs that wait at all
  };
  Waits mean_wait(NodeId node) const;

  // How many of a node's runs come to one output, on average.
  double runs_per_output(NodeId node) const { return costs_.front().runs_per_output(node); }

  // What it does where it finds nothing new. All draws are of runs that are not idle.
  model::IdleRuns idle(NodeId node) const { return costs_.front().idle(node); }

  // On at most `threads`: how many a run works on, and what part each has of its CPU time on one.
  struct Split {
    int threads = 1;
    double part = 1.0;
  };
  Split split(NodeId node, std::size_t kind, int threads) const;

  std::size_t kinds() const { return kinds_; }

 private:
  Samples(const graph::App& app, const model::CostTable& costs);

  void set_wait(std::size_t node, std::size_t number, Nanos wait);
  Nanos& at(std::size_t node, std::size_t kind, std::size_t number) {
    return draws_[(node * kinds_ + kind) * kDraws + number];
  }

  std::size_t kinds_;
  std::vector<int> max_threads_;           // by node
  std::vector<model::CostTable> costs_;    // by kind
  std::vector<Nanos> draws_;               // by node, kind, number
  std::vector<std::vector<Nanos>> waits_;  // by node, number; empty: its runs do not wait
};

}  // namespace ctn::trial
