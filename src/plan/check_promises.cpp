// Rates that must hold, and what the plan says will come of it.
#include <fmt/format.h>

#include <algorithm>

#include "plan/batches.h"
#include "plan/check.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::plan {
namespace {

void check_chains(Check& check, const std::vector<ChainPlan>& must_be) {
  const std::vector<ChainPlan>& planned = check.plan.chains;
  if (planned.size() != must_be.size()) {
    check.problem("chains", fmt::format("{} are planned, the objective has {}", planned.size(), must_be.size()));
    return;
  }
  for (std::size_t i = 0; i < planned.size(); ++i) {
    const auto key = [&](const char* field) { return fmt::format("chains[{}].{}", i, field); };
    if (planned[i].path != must_be[i].path) {
      check.problem(key("path"), fmt::format("the objective has here: {}", check.app.graph.path_name(must_be[i].path)));
      continue;
    }
    check.expect(key("latency_ms"), planned[i].latency, must_be[i].latency, "the row of its subchains");
    check.expect(key("period_ms"), planned[i].period, must_be[i].period, "the slowest of its subchains");
    check.expect(key("response_time_ms"), planned[i].response, must_be[i].response, "latency + period");
    check.expect(key("weight"), planned[i].weight, must_be[i].weight, "the objective");
  }
}

void check_nodes(Check& check, const std::vector<NodePlan>& must_be) {
  const std::vector<NodePlan>& planned = check.plan.nodes;
  if (planned.size() != must_be.size()) {
    check.problem("nodes", fmt::format("{} are planned, the objective has {}", planned.size(), must_be.size()));
    return;
  }
  for (std::size_t i = 0; i < planned.size(); ++i) {
    const auto key = [&](const char* field) { return fmt::format("nodes[{}].{}", i, field); };
    if (planned[i].node != must_be[i].node) {
      check.problem(key("node"), fmt::format("the objective has here: {}", check.app.graph.node(must_be[i].node).name));
      continue;
    }
    check.expect(key("period_ms"), planned[i].period, must_be[i].period, "its subchain");
    check.expect(key("weight"), planned[i].weight, must_be[i].weight, "the objective");
  }
}

// A bound that is missed by no more than rounding may be named or not.
void check_relaxed(Check& check, const Prediction& must_be) {
  check.expect("relaxed.factor", check.plan.relax_factor, must_be.relax_factor, "the bound that is missed most");
  std::vector<RelaxedBound> missing = must_be.relaxed;
  for (std::size_t i = 0; i < check.plan.relaxed.size(); ++i) {
    const RelaxedBound& planned = check.plan.relaxed[i];
    const auto key = [&](const char* field) { return fmt::format("relaxed.bounds[{}].{}", i, field); };
    const auto found = std::find_if(missing.begin(), missing.end(),
                                    [&](const RelaxedBound& bound) { return bound.key == planned.key; });
    if (found != missing.end()) {
      check.expect(key("asked_ms"), planned.asked, found->asked, "the app");
      check.expect(key("planned_ms"), planned.planned, found->planned, "the plan itself");
      missing.erase(found);
    } else if (!same(planned.asked, planned.planned)) {
      check.problem(key("bound"), fmt::format("'{}' is no bound, holds as asked, or is named twice", planned.key));
    }
  }
  for (const RelaxedBound& bound : missing) {
    if (at_least(bound.asked * (1.0 + kTolerance), bound.planned)) continue;
    check.problem("relaxed.bounds", fmt::format("{} is missed ({} ms, asked {} ms) and not named", bound.key,
                                                bound.planned.count(), bound.asked.count()));
  }
}

}  // namespace

void check_rates(Check& check) {
  for (std::size_t i = 0; i < check.plan.subchains.size(); ++i) {
    const SubchainId id{i};
    const Millis period = check.plan.subchains[i].period;
    const PeriodLimits limits = period_limits(check.app.graph, id);
    const std::string key = check.subchain_key(id, "period_ms");
    if (limits.exact) check.expect(key, period, *limits.exact, "an exact rate");
    if (at_least(period, limits.min)) continue;
    check.problem(key, fmt::format("{} ms are shorter than the max_rate of node {} allows: {} ms", period.count(),
                                   check.app.graph.node(*limits.capped).name, limits.min.count()));
  }
}

void check_batches(Check& check, const model::CostTable& costs) {
  const std::optional<std::vector<Batch>> needed = needed_batches(check.plan, check.app, costs);
  if (!needed) return;  // as check_groups() has said
  for (const Batch& need : *needed) {
    const auto planned = std::find_if(check.plan.batches.begin(), check.plan.batches.end(),
                                      [&](const Batch& batch) { return batch.node == need.node; });
    const int items = planned == check.plan.batches.end() ? 0 : planned->items;
    if (items >= need.items) continue;
    check.problem("batches", fmt::format("a run of {} is planned with {} items, and may have {}",
                                         check.app.graph.node(need.node).name, items, need.items));
  }
}

void check_promises(Check& check) {
  const Prediction must_be = predict(check.app, check.costs, check.plan.subchains, check.plan.cores);
  check_chains(check, must_be.chains);
  check_nodes(check, must_be.nodes);
  check.expect("objective", check.plan.objective, must_be.objective, "the weighted sum");
  check_relaxed(check, must_be);
}

}  // namespace ctn::plan
