// Compute-time profiles: what one run of each node costs, as a value that the planner reads. They come from a cost file
// (config), from measurements (estimator.h), or, until measured, from `bootstrap_cost`. A node whose cost depends on
// what it finds to do has modes, each with its own cost; one that runs on several cores may have a measured time for
// each number of threads.
//
// Units: Millis of CPU time, all threads of the node added up, for one run. Thread safety: plain values.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::model {

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
  // Precondition: not empty, probabilities add up to 1.
  static CostProfile of_modes(std::vector<ModeCost> modes);
  // Key: number of threads, >= 1; must hold 1. Value: elapsed time of a run with that many threads.
  static CostProfile of_threads(std::map<int, Millis> elapsed);

  // c: the probability-weighted sum of the modes' percentiles (design section 4; paper section 5.3).
  Millis single_thread() const;
  // c^q: the time one run takes with at most q threads: as measured for the largest measured number of threads <= q,
  // else single_thread() / min(q, max_threads). Precondition: q >= 1, max_threads >= 1.
  Millis with_threads(int q, int max_threads) const;

  const std::vector<ModeCost>& modes() const { return modes_; }
  const std::map<int, Millis>& by_threads() const { return by_threads_; }

  friend bool operator==(const CostProfile&, const CostProfile&) = default;

 private:
  std::vector<ModeCost> modes_{ModeCost{}};
  std::map<int, Millis> by_threads_;
};

// One profile a node, indexed by NodeId. External nodes cost nothing.
class CostTable {
 public:
  // Every node that is not external costs `initial`, unscheduled ones too.
  CostTable(const graph::Graph& graph, Millis initial);

  const CostProfile& operator[](NodeId node) const { return profiles_[node.index()]; }
  void set(NodeId node, CostProfile profile) { profiles_[node.index()] = std::move(profile); }

  // C_i: the sum of single_thread() over the subchain's nodes.
  Millis subchain_total(const graph::Graph& graph, SubchainId subchain) const;

 private:
  std::vector<CostProfile> profiles_;
};

}  // namespace ctn::model
