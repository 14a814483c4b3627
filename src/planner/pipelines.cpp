#include "planner/pipelines.h"

#include <algorithm>
#include <utility>

#include "dispatch/subchain_trigger.h"
#include "model/formulas.h"
#include "plan/limits.h"

namespace ctn::planner {

namespace {

// Mean and percentile of CPU time are in the same proportion on any number of threads.
model::CostTable usual_costs(const graph::App& app, const trial::Samples& samples, model::CostTable costs,
                             std::size_t kind) {
  for (const graph::Subchain& subchain : app.graph.subchains()) {
    for (const NodeId node : subchain.nodes) {
      const Millis planned = costs[node].single_thread();
      if (planned > Millis{0}) costs.set(node, costs[node].times(samples.moments(node, kind).mean / planned.count()));
      costs.set_wait(node, Millis{samples.mean_wait(node).mean});
    }
  }
  return costs;
}

// So many cores can be of use to it at once.
int useful_cores(const graph::App& app, const model::CostTable& costs, SubchainId id, int cores) {
  const auto nodes = static_cast<long long>(app.graph.subchain(id).nodes.size());
  return static_cast<int>(std::min<long long>(cores, nodes * costs.max_useful_threads(app.graph, id)));
}

}  // namespace

Pipelines::Pipelines(const graph::App& app, const trial::Samples& samples, const model::CostTable& planned,
                     double slack)
    : app_(app), slack_(slack), promised_(model::costs_by_kind(app, planned)) {
  for (std::size_t kind = 0; kind < promised_.size(); ++kind) {
    usual_.push_back(usual_costs(app, samples, promised_[kind], kind));
  }
  constexpr int kAny = 1 << 20;
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    // One that what arrives has to trigger is never paced by its own outputs.
    const bool by_arrival =
        app.graph.node(app.graph.subchain(SubchainId(i)).head()).trigger == graph::TriggerBy::kArrival;
    const std::vector<NodeId>& nodes = app.graph.subchain(SubchainId(i)).nodes;
    batches_.push_back(std::any_of(nodes.begin(), nodes.end(), [&](NodeId node) { return planned.has_batches(node); }));
    const bool excluded = std::any_of(nodes.begin(), nodes.end(),
                                      [&](NodeId node) { return app.graph.node(node).exclusive.has_value(); });
    const bool one = by_arrival || batches_.back() || excluded;
    max_cores_.push_back(one ? 1 : useful_cores(app, planned, SubchainId(i), kAny));
  }
}

std::optional<trial::Pipeline> Pipelines::on(SubchainId subchain, std::vector<int> cores) const {
  if (batches_[subchain.index()]) return std::nullopt;
  const std::size_t kind = app_.kind_of(cores.front());
  const int count = static_cast<int>(cores.size());
  const plan::PeriodLimits limits = plan::period_limits(app_.graph, subchain);
  const model::OwnedCores promised = model::owned_cores(app_.graph, subchain, promised_[kind], count, slack_);
  if (limits.exact && promised.period > *limits.exact) return std::nullopt;
  const model::OwnedCores usual =
      model::owned_cores_with(app_.graph, subchain, usual_[kind], count, promised.threads, slack_);
  const dispatch::Pacing pacing = dispatch::pacing_of_owner(
      {.promised = {limits.exact.value_or(std::max(promised.period, limits.min)), promised.execution},
       .expected = {std::max(usual.period, limits.min), usual.execution}},
      limits, app_.scheduler.frames == graph::FrameMode::kFixed, Nanos{0});
  return trial::Pipeline{subchain, std::move(cores), promised.threads, pacing};
}

plan::SubchainPlan planned_pipeline(const graph::App& app, const model::CostTable& costs,
                                    const trial::Pipeline& pipeline, double slack) {
  const plan::PeriodLimits limits = plan::period_limits(app.graph, pipeline.subchain);
  const model::OwnedCores owned = model::owned_cores_with(
      app.graph, pipeline.subchain, costs, static_cast<int>(pipeline.cores.size()), pipeline.threads, slack);
  plan::SubchainPlan planned;
  planned.cores = pipeline.cores;
  planned.threads = pipeline.threads;
  planned.period = limits.exact.value_or(std::max(owned.period, limits.min));
  planned.execution = owned.execution;
  planned.wait = costs.subchain_wait(app.graph, pipeline.subchain);
  planned.slice = costs.subchain_total(app.graph, pipeline.subchain);
  if (!plan::takes_batches(app.graph, pipeline.subchain)) planned.every = 1;
  return planned;
}

}  // namespace ctn::planner
