// For tests: what runs of a trial cost, and what a record would make of them.
#pragma once

#include <cstddef>

#include "graph/app.h"
#include "model/cost.h"
#include "model/workload.h"
#include "record/run_metrics.h"
#include "trial/trial.h"

namespace ctn {

// Runs vary: half of them cost at most two thirds of what plans take a run to cost.
inline model::Workload varying(const graph::App& app, const model::CostTable& costs) {
  model::Workload work(app.graph);
  for (std::size_t kind = 0; kind < app.kinds(); ++kind) {
    const model::CostTable there = costs.on(app, kind);
    for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
      const NodeId id(node);
      if (app.graph.node(id).external) continue;
      const Millis cost = there[id].single_thread();
      const model::NodeWork law{model::CostProfile::constant(cost), {cost * 0.66}, 0.0, {}};
      app.core_kinds.empty() ? work.set(id, law) : work.set_on(id, kind, law);
    }
  }
  for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
    const Millis wait = costs.wait(NodeId(node));
    if (wait > Millis{0}) work.set_wait(NodeId(node), {wait, wait * 0.66});
  }
  return work;
}

// The terms, from the runs that a trial reports.
template <class Sum>
class Measured : public trial::Observer {
 public:
  Measured(const graph::App& app, record::Interval interval) : metrics_(app, interval) {}
  void ended(const trial::ObservedRun& run) override {
    record::Run recorded;
    recorded.node = run.node;
    recorded.number = run.number;
    recorded.begin = run.begin;
    recorded.end = run.end;
    recorded.emitted = run.emitted;
    for (const auto& [predecessor, first, last] : run.consumed) recorded.consumed.push_back({predecessor, first, last});
    metrics_.add(recorded);
  }
  void set_clock(NodeId node, const Ticks& ticks) { metrics_.set_clock(node, ticks); }
  const record::RunMetrics<Sum>& metrics() const { return metrics_; }

 private:
  record::RunMetrics<Sum> metrics_;
};

}  // namespace ctn
