// What a subchain does with several cores of its own, where its runs overlap: by the formulas of the model
// (model/formulas.h). Promised at the planned percentiles, but paced by what runs cost on average: a percentile of few
// runs may be twice that, and a subchain that is paced by it is as slow as it says.
//
// Units: in the types. Thread safety: const functions, any thread.
#pragma once

#include <optional>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "trial/samples.h"
#include "trial/schedule.h"

namespace ctn::planner {

class Pipelines {
 public:
  // `app` outlives it.
  Pipelines(const graph::App& app, const trial::Samples& samples, const model::CostTable& planned, double slack);

  // The largest number of cores that the subchain can use at once.
  int max_cores(SubchainId subchain) const { return max_cores_[subchain.index()]; }

  // On these cores, at the number of threads with the least execution time and period together. None where an exact
  // rate cannot be promised, or runs depend on the size of batches: how long they take, and so the pace, depends on how
  // often others run. Precondition: cores in ascending order, all of one kind.
  std::optional<trial::Pipeline> on(SubchainId subchain, std::vector<int> cores) const;

 private:
  const graph::App& app_;
  double slack_;
  std::vector<model::CostTable> promised_;  // by kind of core
  std::vector<model::CostTable> usual_;     // by kind of core
  std::vector<bool> batches_;               // by SubchainId: its runs depend on the size of batches
  std::vector<int> max_cores_;              // by SubchainId
};

// A pipeline in a plan, with as many threads as it has. `costs`: planned, on its kind of cores.
plan::SubchainPlan planned_pipeline(const graph::App& app, const model::CostTable& costs,
                                    const trial::Pipeline& pipeline, double slack);

}  // namespace ctn::planner
