// What a run of an app came to: from its record to figures, predictions next to measurements.
//
// Measured is what happened between the end of the warm-up (`Header::warm_up`, which the runtime states whatever the
// scheduler) and the end of the run: a figure counts if all that it spans lies in that interval. Predicted is what the
// plans in force in it said, each weighted by how long it was in force.
//
// Units: milliseconds, hertz, and cores (CPU time / time), as the names say. Thread safety: plain values.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/statistics.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "plan/predicted_means.h"
#include "record/events.h"
#include "record/reader.h"
#include "why/analysis.h"

namespace ctn::report {

using plan::ChainPrediction;

// A response time of the objective.
struct ChainMetrics {
  std::string path;
  double weight = 0.0;
  std::optional<double> bound_ms;
  Summary response_ms;
  Summary latency_ms;
  Summary period_ms;
  std::optional<ChainPrediction> predicted;  // none: no plan was in force
  std::optional<why::Analysis> late;         // which responses were late, and why; none: it was not asked
};

// A node that is not external.
struct NodeMetrics {
  std::string name;
  std::uint64_t runs = 0;
  std::uint64_t outputs = 0;       // runs that emitted
  double rate_hz = 0.0;            // runs / time
  Summary period_ms;               // between the ends of consecutive runs that count (record/run_metrics.h)
  Summary compute_ms;              // CPU time of a run
  Summary wall_ms;                 // begin to end of a run
  std::optional<Summary> wait_ms;  // of a run: it neither ran nor was ready to. None: no run waited
  double cores = 0.0;              // CPU time / time
  std::optional<double> weight;    // of its period, where the objective has it
  std::optional<double> predicted_rate_hz;
};

// How late the triggers of a subchain were sent: sent - due.
struct TriggerMetrics {
  std::string subchain;
  Summary late_ms;
};

// The weighted sum that was planned for, where all of its terms were measured (mean values) or predicted.
struct ObjectiveMetrics {
  std::optional<double> measured;
  std::optional<double> predicted;
};

// A weight or a bound that was changed while the app ran.
struct AppChangeMetrics {
  double at_s = 0.0;  // since the start
  std::string what;   // as record::describe() has it
};

struct RunFigures {
  std::string app;
  record::Header header;
  record::Ending ending;
  bool whole = false;         // the warm-up is included
  double measured_s = 0.0;    // length of what is measured
  std::uint64_t plans = 0;    // that were in force in it
  double relax_factor = 1.0;  // the largest among them
  bool for_typical = false;   // what some of them promise is for typical compute times
  ObjectiveMetrics objective;
  std::vector<ChainMetrics> chains;       // in the order of the objective
  std::vector<NodeMetrics> nodes;         // in the order of the app
  std::vector<AgeSnapshot> ages;          // edges with an age limit
  std::vector<TriggerMetrics> triggers;   // those that were sent any
  double cores_used = 0.0;                // by all nodes together; of header.cpus.size()
  std::vector<AppChangeMetrics> changes;  // of the whole run: figures are by what was in force at its end
  std::vector<record::Notice> notices;    // of the whole run
};

struct Asked {
  bool whole = false;  // include the warm-up
  // What made responses late (docs/why.md): so many of each chain, the longest, are taken apart. None: it is not asked;
  // then the record is read once, not twice.
  std::optional<std::size_t> worst = std::nullopt;
  // Is shown every run of the record, as Reader::each_run() does.
  std::function<void(const record::Run&)> see = {};
};

// Errors: those of the reader; a plan in the record that cannot be read (kCaller).
Result<RunFigures> measure(const record::Reader& record, const Asked& asked = {});

}  // namespace ctn::report
