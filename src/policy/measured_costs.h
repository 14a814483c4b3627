// What runs of all nodes of an app are like as measured, and thus what is planned with: what they cost, and cost more
// with each item of a batch, what they wait, and how many come to one output where the app file gives no
// `output_period`.
//
// Idle runs, which found nothing new and gave no output, are told apart from the others: how many there are is the
// schedule's doing. What they cost counts only as long as the node has had no others: else that node would be taken for
// one that never ran. A queue node's runs need no such distinction: what is idle of them is a batch of no items.
//
// Units: Nanos in, milliseconds out. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"
#include "policy/batch_sizes.h"
#include "policy/node_costs.h"
#include "policy/node_outputs.h"
#include "record/events.h"
#include "trial/samples.h"

namespace ctn::policy {

class MeasuredCosts {
 public:
  // `app` outlives it.
  explicit MeasuredCosts(const graph::App& app, RunsThatCount count = RunsThatCount::kRecent);

  // A run on a core of that kind; in the order of their ends, each after those that it consumed. Where it shows that
  // the node's compute time has changed permanently: from what to what.
  std::optional<record::CostChange> add(const record::Run& run, std::size_t kind) {
    const bool idle = outputs_[run.node.index()].add(run);
    const std::size_t items = batches_.taken_by(run);
    batches_.ended(run);
    if (!counts(run.node, idle)) return std::nullopt;
    return nodes_[run.node.index()].add(run, items, kind);
  }
  // When an external node ticks is known, from the next run on.
  void set_clock(NodeId node, const Ticks& ticks);

  // What runs on cores of that kind take now, whatever was measured: so many times as much; or it is not known.
  void rescale(std::size_t kind, double factor);
  void invalidate(std::size_t kind);

  // The scheduled nodes that have not run, and how many have.
  std::vector<NodeId> unknown() const;
  std::size_t known() const;
  // The smallest number of runs that any scheduled node has had, of those that have run; 0: none has.
  std::size_t min_runs() const;
  // What the planner is to reckon with; nodes that have not run keep `unmeasured`.
  model::CostTable costs(Millis unmeasured) const { return costs_at(app_.scheduler.percentile, unmeasured); }
  // What runs typically cost: the median where costs() has the percentile.
  model::CostTable typical_costs(Millis unmeasured) const;
  // Recent runs, by node and kind of core, as often each as runs like it occur.
  trial::MeasuredRuns runs() const;

 private:
  // Whether such a run of the node tells what its runs cost.
  bool counts(NodeId node, bool idle);
  model::CostTable costs_at(double percentile, Millis unmeasured) const;

  const graph::App& app_;
  BatchSizes batches_;
  std::vector<NodeCosts> nodes_;      // by NodeId
  std::vector<NodeOutputs> outputs_;  // by NodeId
  std::vector<bool> worked_;          // by NodeId: a run was not idle
};

}  // namespace ctn::policy
