// Batches in plans: where a run of a queue node costs more with each item (model/cost.h), a plan says how many items a
// run was taken to have, at most (plan::Batch), and is then a plan at costs that depend on nothing any more. It is
// sound if its own periods bring no more (model/batches.h). Since periods follow from costs, and items from periods, a
// plan is made again with more items until that is so.
//
// The longest time between the begins of two runs is, with a fixed priority, the promised period and what a run may be
// held up, L - c; in frames and on cores of its own, the period. Two outputs are as far apart as triggers are at least,
// on average (promise.h), and as planned periods. A subchain that runs more often than planned brings more: elastic
// frames that end early, or cores of one's own.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

// The costs of runs with such batches; those that make no sense, in a plan that is still to be checked, have no items.
model::CostTable at_batches(const model::CostTable& costs, const std::vector<Batch>& batches,
                            const graph::Graph& graph);

// By NodeId, of nodes that have batches at these costs: what the plan's own periods bring at most. None where the
// plan's fixed priorities promise some subchain nothing.
std::optional<std::vector<Batch>> needed_batches(const Plan& plan, const graph::App& app,
                                                 const model::CostTable& costs);

// One item of each predecessor.
std::vector<Batch> first_batches(const graph::Graph& graph, const model::CostTable& costs);
// Makes all as large as needed, in later rounds larger than that, so that there is an end to it. False: they were.
// Precondition: of the same nodes.
bool enlarge(std::vector<Batch>& batches, const std::vector<Batch>& needed, int round);

// What `make` makes of batches that suffice for it. `make`: from batches to a plan that says them
// (std::optional<Plan>).
template <class Make>
std::optional<Plan> settle_batches(const graph::App& app, const model::CostTable& costs, const Make& make) {
  std::vector<Batch> batches = first_batches(app.graph, costs);
  for (int round = 0;; ++round) {
    std::optional<Plan> plan = make(std::as_const(batches));
    if (!plan || batches.empty()) return plan;
    const std::optional<std::vector<Batch>> needed = needed_batches(*plan, app, costs);
    if (!needed) return std::nullopt;
    if (!enlarge(batches, *needed, round)) return plan;
  }
}

// What runs are expected to cost at the plan's periods: with as many items as these bring on average.
model::CostTable at_mean_batches(const Plan& plan, const graph::Graph& graph, const model::CostTable& costs);

}  // namespace ctn::plan
