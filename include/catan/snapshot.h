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
  std::optional<double> min_rate_hz{};  // that is asked for at present
};

// A term of the objective, as it counts at present.
struct TermSnapshot {
  std::string term;  // "scan -> LM", "period of LM"
  double weight = 0.0;
  std::optional<double> max_ms;  // bound of a response time
};

// An edge with an age limit (`max_age`).
struct AgeSnapshot {
  std::string from;
  std::string to;
  double max_age_ms = 0.0;
  bool skips = false;       // stale runs give no output
  std::uint64_t runs = 0;   // of `to`, whose input had an age
  std::uint64_t stale = 0;  // of these, above the limit
  Summary age_ms;           // when they began (Run::age())
};

// A bound of the app file that the plan in force does not keep. A rate counts as the period that it asks for.
struct RelaxedBoundSnapshot {
  std::string bound;  // "objective[0].max", "nodes.GL.min_rate"
  double asked_ms = 0.0;
  double planned_ms = 0.0;
};

// A node that had not run when the plan in force was made, and what it was taken to cost.
struct AssumedCostSnapshot {
  std::string node;
  double cost_ms = 0.0;
};

struct Snapshot {
  std::string policy;
  bool real_time = false;             // levels are enforced; else rates only
  bool warmed_up = false;             // the bootstrap is over; what was measured in it is left out below
  std::vector<int> cpus;              // that are planned for
  std::uint64_t changes = 0;          // how often weights, bounds or CPUs were changed while it ran
  double source_hz = 0.0;             // rate of the first subchain's head, as planned or hand-set
  std::uint64_t plans = 0;            // plans that came into force, the bootstrap's included
  std::uint64_t cost_changes = 0;     // how often a node's compute time changed permanently
  double planning_ms = 0.0;           // CPU time that new plans have taken
  std::uint64_t budget_overruns = 0;  // how often a run was demoted, since it used more CPU time than its budget
  std::uint64_t starved = 0;          // how often the kernel kept a CPU from real-time threads
  double starved_ms = 0.0;            // and for how long, on all CPUs
  double relax_factor = 1.0;          // of the plan in force: by which its bounds are relaxed; 1: all hold
  std::vector<RelaxedBoundSnapshot> relaxed;
  std::vector<AssumedCostSnapshot> assumed;
  std::vector<TermSnapshot> objective;
  std::vector<ChainSnapshot> chains;  // the objective's response times
  std::vector<NodeSnapshot> nodes;    // those that are not external
  std::vector<AgeSnapshot> ages;      // edges with an age limit
  std::vector<std::string> notices;
};

}  // namespace ctn
