// What follows from the subchains of a plan by the formulas of the model: chains, nodes, the objective, and which
// bounds do not hold. Each planner fills it in with this; `validate` compares with it.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include <span>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

// Two figures are the same if they differ by no more than one part in this.
constexpr double kTolerance = 1e-9;

struct Prediction {
  std::vector<ChainPlan> chains;
  std::vector<NodePlan> nodes;
  double objective = 0.0;
  double relax_factor = 1.0;          // the least by which all bounds would have to be scaled to hold
  std::vector<RelaxedBound> relaxed;  // those that do not hold as asked
};

// `cores`: where it says which subchain follows which; empty: none does. Precondition: one entry a subchain of the app.
Prediction predict(const graph::App& app, const model::CostTable& costs, std::span<const SubchainPlan> subchains,
                   std::span<const CorePlan> cores);

// Puts the prediction for `plan.subchains` into the plan.
void fill_predictions(Plan& plan, const graph::App& app, const model::CostTable& costs);

// What the plan is expected to give at typical compute times (a median of what was measured, say; batches as its
// periods bring them on average) under the dispatcher's frames: with elastic ones the periods follow from `typical` by
// the formulas that the plan itself was made with, though never longer than planned nor shorter than a cap allows;
// fixed frames and exact rates keep the planned periods; with fixed priorities, the promise for `typical` (promise.h).
// On shared cores an elastic frame takes what its slots use of it, and a run takes from the begin of its first slot to
// where it ends in its last, and what it waits.
Expectation expect(const Plan& plan, const graph::App& app, const model::CostTable& typical);

}  // namespace ctn::plan
