// What a session has measured: estimates for the planner, samples for the snapshot. Told of runs in an order in which
// each comes after those it consumed.
//
// Units: Nanos in, milliseconds out. Thread safety: none; the owner locks. Memory: bounded, the newest `kSamples` of
// each metric.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "catan/snapshot.h"
#include "graph/app.h"
#include "plan/plan.h"
#include "policy/cpu_kinds.h"
#include "policy/measured_costs.h"
#include "record/events.h"
#include "record/lineage.h"

namespace ctn::runtime {

// The newest samples of one metric.
class SampleWindow {
 public:
  static constexpr std::size_t kSamples = 16384;

  void add(double sample);
  Summary summary() const;  // count: all there ever were; the rest: of those kept

 private:
  std::vector<double> samples_;
  std::size_t next_ = 0;
  std::uint64_t count_ = 0;
};

class Measurements {
 public:
  // Samples that go back to a time before `warm_from` are left out of the snapshot (the estimates take all).
  Measurements(const graph::App& app, TimePoint warm_from, policy::CpuKinds kinds = {});

  // Where it shows that the node's compute time has changed for good: from what to what. `tells_costs`: false for a run
  // that is no measure of what the node costs (policy/hung_runs.h).
  std::optional<record::CostChange> add(const record::Run& run, bool tells_costs = true);

  // What nodes cost, of all runs.
  policy::MeasuredCosts& measured() { return costs_; }
  const policy::MeasuredCosts& measured() const { return costs_; }

  // Predictions are averaged over the time they were in force, from `warm_from` on.
  void plan_in_force(TimePoint since, const plan::Plan& plan, Rate source_rate);

  // Fills chains, nodes, predictions and source_hz, as of `now`. `hand_set_hz`: where no plan tells.
  void fill(Snapshot& snapshot, TimePoint now, std::optional<double> hand_set_hz) const;

 private:
  struct ChainMeasure {
    record::ChainTracker tracker;
    std::vector<NodeId> path;
    SampleWindow response;
    SampleWindow latency;
    SampleWindow period;
    TimePoint last_begin{};
  };
  struct NodeMeasure {
    SampleWindow compute;
    std::uint64_t runs = 0;
  };
  // What a plan promised; summed up, each weighted with the seconds it was in force.
  struct Prediction {
    double seconds = 0.0;
    double source_hz = 0.0;
    std::vector<double> responses;

    void accumulate(const Prediction& other, double for_seconds);
  };

  // The mean over the measured interval as of `now`; none before a plan was in force.
  std::optional<Prediction> mean_prediction(TimePoint now) const;
  double seconds_in_force(TimePoint until) const;

  const graph::App& app_;
  TimePoint warm_from_;
  policy::CpuKinds kinds_;
  policy::MeasuredCosts costs_;
  std::vector<ChainMeasure> chains_;  // one a response-time term, in order
  std::vector<NodeMeasure> nodes_;    // by NodeId
  Prediction past_;                   // plans that are no longer in force
  std::optional<Prediction> current_;
  TimePoint current_since_{};
};

}  // namespace ctn::runtime
