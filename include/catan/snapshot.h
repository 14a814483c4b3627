// What a session measured so far, next to what was predicted. Times in milliseconds. Plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "catan/summary.h"

namespace ctn {

struct ChainSnapshot {
  std::vector<std::string> path;
  Summary response_ms;
  Summary latency_ms;
  Summary period_ms;
  std::optional<double> predicted_response_ms;  // none where no plan was made
};

struct NodeSnapshot {
  std::string name;
  Summary compute_ms;
  double rate_hz = 0.0;
};

struct Snapshot {
  std::string policy;
  bool real_time = false;             // levels are enforced; else rates only
  bool warmed_up = false;             // the bootstrap is over; what was measured in it is left out below
  double source_hz = 0.0;             // rate of the first subchain's head, as planned or hand-set
  std::uint64_t plans = 0;            // plans that came into force, the bootstrap's included
  std::uint64_t cost_changes = 0;     // how often a node's compute time changed permanently
  double planning_ms = 0.0;           // CPU time that new plans have taken
  std::uint64_t budget_overruns = 0;  // how often a run was demoted, since it used more CPU time than its budget
  std::uint64_t starved = 0;          // how often the kernel kept a CPU from real-time threads
  double starved_ms = 0.0;            // and for how long, on all CPUs
  std::vector<ChainSnapshot> chains;  // the objective's response times
  std::vector<NodeSnapshot> nodes;    // those that are not external
  std::vector<std::string> notices;
};

}  // namespace ctn
