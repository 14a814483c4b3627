// The outcome of a simulation, and its collector: run by run, in bounded memory.
//
// What counts is what lies between the end of the warm-up and the end, all that it spans included, as in the report of
// a real run (report/metrics.h).
//
// Units: milliseconds, hertz and fractions, as the names say. Thread safety: plain values; OutcomeCollector has one
// owner.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "graph/app.h"
#include "plan/plan.h"
#include "plan/predicted_means.h"
#include "record/events.h"
#include "record/run_metrics.h"
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

// An edge with an age limit.
struct AgeOutcome {
  std::string from;
  std::string to;
  double max_age_ms = 0.0;
  bool skips = false;       // stale runs give no output
  std::uint64_t runs = 0;   // of `to`, whose input has an age
  std::uint64_t stale = 0;  // of these, older than the limit
  Summary age_ms;
};

struct CoreOutcome {
  double real_time = 0.0;  // of the time
  double ordinary = 0.0;
};

struct Outcome {
  std::string app;
  std::string scheduler;
  double measured_s = 0.0;
  double source_hz =
      0.0;  // rate of the first subchain's head, as planned (averaged over the plans in force) or hand-set
  std::vector<ChainOutcome> chains;  // in the order of the objective
  std::vector<NodeOutcome> nodes;    // in the order of the app
  std::vector<AgeOutcome> ages;      // edges with an age limit, in the order of the app
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
  std::vector<std::string> notices;  // plans that could not be made
};

class OutcomeCollector {
 public:
  // `app` outlives it.
  OutcomeCollector(const graph::App& app, TimePoint warm_from);

  // A run has ended; each after those it consumed.
  void add(const record::Run& run) { metrics_.add(run); }
  void clock_read(const record::ClockReading& reading) { metrics_.set_clock(reading.node, reading.ticks); }
  void triggered(TimePoint at) { triggers_ += at >= warm_from_ ? 1U : 0U; }
  void stole(TimePoint begin) { steals_ += begin >= warm_from_ ? 1U : 0U; }
  void over_budget(TimePoint at) { budget_overruns_ += at >= warm_from_ ? 1U : 0U; }
  void plan_in_force(TimePoint since, const plan::Plan& plan) { predicted_.in_force(since, plan); }

  // All but what only the simulation knows.
  Outcome outcome(TimePoint end) const;

 private:
  void measure_objective(Outcome& outcome) const;

  const graph::App& app_;
  TimePoint warm_from_;
  record::RunMetrics<Histogram> metrics_;
  plan::PredictedMeans predicted_;
  std::uint64_t triggers_ = 0;
  std::uint64_t steals_ = 0;
  std::uint64_t budget_overruns_ = 0;
};

}  // namespace ctn::sim
