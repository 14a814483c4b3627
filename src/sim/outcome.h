// The outcome of a simulation, from what was measured in it (driver/measurements.h), in bounded memory.
//
// What counts is what lies between the end of the warm-up and the end, all that it spans included, as in the report of
// a real run (report/metrics.h).
//
// Units: milliseconds, hertz and fractions, as the names say. Thread safety: plain values and a pure function.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "catan/snapshot.h"
#include "driver/event_log.h"
#include "driver/measurements.h"
#include "graph/app.h"
#include "sim/histogram.h"

namespace ctn::sim {

// A response time of the objective.
struct ChainOutcome {
  std::string path;
  double weight = 0.0;
  std::optional<double> bound_ms;
  std::uint64_t over_bound = 0;  // response times above it
  Summary response_ms;
  Summary latency_ms;
  Summary period_ms;
  std::optional<double> predicted_ms;  // response time, averaged over the plans in force
};

// A node that is not external.
struct NodeOutcome {
  std::string name;
  std::uint64_t runs = 0;
  std::uint64_t outputs = 0;
  double rate_hz = 0.0;
  bool too_slow = false;  // below its min_rate
  bool too_fast = false;  // above its max_rate
  Summary period_ms;
  Summary compute_ms;
  std::optional<Summary> wait_ms;  // none: its runs did not wait
};

struct CoreOutcome {
  double real_time = 0.0;  // of the time
  double ordinary = 0.0;
};

struct Outcome {
  std::string app;
  std::string scheduler;
  double measured_s = 0.0;
  // Rate of the first subchain's head, as planned (averaged over the plans in force) or set by hand.
  double source_hz = 0.0;
  std::vector<ChainOutcome> chains;  // in the order of the objective
  std::vector<NodeOutcome> nodes;    // in the order of the app
  std::vector<AgeSnapshot> ages;     // edges with an age limit, in the order of the app
  std::vector<CoreOutcome> cores;
  std::optional<double> objective;            // as measured, of means; none where a term was not
  std::optional<double> objective_predicted;  // averaged over the plans in force; none without a plan
  double relax_factor = 1.0;                  // the largest of plans in force
  std::uint64_t triggers = 0;
  std::uint64_t steals = 0;
  std::uint64_t hangs = 0;
  std::uint64_t budget_overruns = 0;  // runs that were demoted
  std::uint64_t dropped = 0;          // values that a full queue lost
  std::uint64_t throttled = 0;        // how often real-time threads were kept from a core for the sake of ordinary ones
  std::uint64_t plans_made = 0;
  std::uint64_t plans_adopted = 0;  // the first included
  std::uint64_t cost_changes = 0;
  std::vector<std::string> notices;  // the newest, as a user of a real session gets them
};

using Measurements = driver::Measurements<Histogram>;
using EventLog = driver::EventLog<Histogram>;

// All but what only the simulation knows, up to `end`.
Outcome outcome_of(const graph::App& app, const Measurements& measured, TimePoint end);

}  // namespace ctn::sim
