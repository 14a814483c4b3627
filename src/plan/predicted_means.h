// What plans promise, averaged over the time that each was in force: to be compared with what was measured in that
// time. A plan that says what it expects is taken by that, since means are compared with means.
//
// Units: milliseconds and hertz, as the names say. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::plan {

// Expected: at typical compute times, to be compared with measured means. Promised: the plan's worst case, at the
// costs that its promises are for, to be compared with the measured tail.
struct ChainPrediction {
  double response_ms = 0.0;  // expected
  double latency_ms = 0.0;   // expected
  double period_ms = 0.0;    // expected
  double promised_response_ms = 0.0;
};

struct Predictions {
  std::uint64_t plans = 0;  // that were in force at any time
  std::optional<double> objective;
  double relax_factor = 1.0;                           // the largest among the plans
  bool for_typical = false;                            // some plan's promises are for typical compute times
  std::vector<std::optional<ChainPrediction>> chains;  // by response-time term, in the order of the objective
  std::vector<std::optional<double>> rate_hz;          // by NodeId; none: not in a subchain, or no plan in force
  std::optional<double> source_hz;                     // rate of the first subchain's head
};

// The figures of one plan.
Predictions predictions_of(const Plan& plan, const graph::App& app);

class PredictedMeans {
 public:
  // Time before `from` does not count. `app` outlives it.
  PredictedMeans(const graph::App& app, TimePoint from);

  // From then on, in place of the one before. Precondition: calls come in the order of time.
  void in_force(TimePoint since, const Plan& plan);

  // Means up to then. Time before the first plan counts for nothing.
  Predictions until(TimePoint end) const;
  // The figures of the plan that is in force, whether any of its time counts or not; none before the first.
  std::optional<Predictions> current() const { return current_; }

 private:
  struct Mean {
    double sum = 0.0;
    double weight = 0.0;

    void add(std::optional<double> value, double seconds);
    std::optional<double> value() const { return weight > 0.0 ? std::optional(sum / weight) : std::nullopt; }
  };
  struct ChainMeans {
    Mean response;
    Mean latency;
    Mean period;
    Mean promised;
  };
  struct Means {
    std::uint64_t plans = 0;
    Mean objective;
    double relax_factor = 1.0;
    bool for_typical = false;
    std::vector<ChainMeans> chains;
    std::vector<Mean> rates;
  };

  // Adds the plan that is in force, for its time up to then.
  void add_current(Means& means, TimePoint end) const;

  const graph::App& app_;
  TimePoint from_;
  Means past_;  // of plans that are no longer in force
  std::optional<Predictions> current_;
  TimePoint current_since_{};
};

}  // namespace ctn::plan
