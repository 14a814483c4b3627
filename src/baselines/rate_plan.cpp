#include "baselines/rate_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/evaluate.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "planner/planner.h"

namespace ctn::baselines {
namespace {

Error mistake(std::string key, std::string what, std::string hint) {
  return Error(ErrorKind::kCaller, {Problem{{}, std::move(key), std::move(what), std::move(hint)}});
}

Error broken(std::string what) { return Error(ErrorKind::kCaller, {Problem{{}, {}, std::move(what), {}}}); }

bool longer(double a, double b) { return a > b * (1.0 + plan::kTolerance); }
bool differ(double a, double b) { return std::abs(a - b) > plan::kTolerance * std::max(std::abs(a), std::abs(b)); }

std::vector<model::SubchainTiming> timings_of(const RatePlan& plan) {
  std::vector<model::SubchainTiming> timings;
  for (const TaskPlan& task : plan.subchains) timings.push_back({task.period, task.response});
  return timings;
}

std::vector<double> utilisations_of(const RatePlan& plan, const graph::App& app, const model::CostTable& costs,
                                    int cores) {
  const std::vector<std::vector<double>> stretched = stretched_costs(app, costs, plan.slack);
  std::vector<double> used(static_cast<std::size_t>(cores), 0.0);
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const TaskPlan& task = plan.subchains[i];
    used[static_cast<std::size_t>(task.core)] += stretched[app.kind_of(task.core)][i] / task.period.count();
  }
  return used;
}

}  // namespace

Status check_request(const graph::App& app, const RateRequest& request) {
  if (request.cores < 1 || request.cores > planner::kMaxCores) {
    return mistake("cores", fmt::format("{} cores", request.cores), fmt::format("1 to {}", planner::kMaxCores));
  }
  if (const auto listed = app.core_count(); listed && request.cores > *listed) {
    return mistake("cores", fmt::format("{} cores, but the app lists {}", request.cores, *listed),
                   "list more under cores, or ask for fewer");
  }
  if (!(request.slack >= 0.0 && request.slack < 1.0)) {
    return mistake("slack", fmt::format("a slack of {}", request.slack), "a fraction from 0 to below 1");
  }
  if (app.graph.subchains().empty()) return mistake("nodes", "nothing to schedule", "give a node that is scheduled");
  if (app.graph.subchains().size() > planner::kMaxSubchains) {
    return mistake("subchains", fmt::format("{} subchains", app.graph.subchains().size()),
                   fmt::format("at most {}", planner::kMaxSubchains));
  }
  return Done{};
}

void fill_figures(RatePlan& plan, const graph::App& app, const model::CostTable& costs, int cores,
                  const std::vector<ChainBound>& chains) {
  const std::vector<model::SubchainTiming> timings = timings_of(plan);
  plan.utilisations = utilisations_of(plan, app, costs, cores);
  plan.chains.clear();
  plan.nodes.clear();
  plan.relaxed.clear();
  plan.objective = plan.formula_objective = 0.0;
  plan.relax_factor = 1.0;
  std::vector<Millis> of_term;
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kPeriod) {
      of_term.push_back(model::evaluate_period(app.graph, term.path.front(), timings));
      plan.nodes.push_back({term.path.front(), of_term.back(), term.weight});
      plan.formula_objective += term.weight * of_term.back().count();
    } else {
      const ChainBound& bound = chains[plan.chains.size()];
      of_term.push_back(bound.response);
      plan.chains.push_back({term.path, bound.response, bound.latency, bound.response - bound.latency, term.weight});
      plan.formula_objective +=
          term.weight * model::evaluate_chain(app.graph, term.path, costs, timings).response.count();
    }
    plan.objective += term.weight * of_term.back().count();
  }
  for (const plan::SoftBound& bound : plan::soft_bounds(app)) {
    const Millis planned = bound.term ? of_term[*bound.term] : model::evaluate_period(app.graph, *bound.node, timings);
    if (!longer(planned.count(), bound.asked.count())) continue;
    plan.relaxed.push_back({bound.key, bound.asked, planned});
    plan.relax_factor = std::max(plan.relax_factor, planned / bound.asked);
  }
}

Status check_rates(const RatePlan& plan, const graph::App& app, const model::CostTable& costs, int cores) {
  const graph::Graph& graph = app.graph;
  if (plan.subchains.size() != graph.subchains().size()) return broken("not one entry a subchain");
  std::vector<bool> taken(plan.subchains.size(), false);
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const TaskPlan& task = plan.subchains[i];
    const std::string& name = graph.subchains()[i].name;
    if (task.core < 0 || task.core >= cores) return broken(fmt::format("{}: core {}", name, task.core));
    const auto rank = static_cast<std::size_t>(task.priority);
    if (rank < 1 || rank > taken.size() || taken[rank - 1]) return broken(fmt::format("{}: priority {}", name, rank));
    taken[rank - 1] = true;
    const double period = task.period.count();
    if (!std::isfinite(period) || period <= 0.0) return broken(fmt::format("{}: a period of {}ms", name, period));
    const plan::PeriodLimits limits = plan::period_limits(graph, SubchainId(i));
    if (longer(limits.min.count(), period)) return broken(name + ": more often than max_rate");
    if (limits.exact && differ(limits.exact->count(), period)) return broken(name + ": not at its exact rate");
    if (longer(task.response.count(), period)) return broken(name + ": a run may outlast its period");
  }
  const std::vector<double> used = utilisations_of(plan, app, costs, cores);
  if (plan.utilisations.size() != used.size()) return broken("not one utilisation a core");
  for (std::size_t core = 0; core < used.size(); ++core) {
    if (longer(used[core], 1.0)) return broken(fmt::format("core {}: a utilisation of {}", core, used[core]));
    if (differ(used[core], plan.utilisations[core])) return broken(fmt::format("core {}: utilisation", core));
  }
  std::vector<ChainBound> chains;
  for (const plan::ChainPlan& chain : plan.chains) chains.push_back({chain.response, chain.latency});
  const auto terms = std::count_if(app.objective.begin(), app.objective.end(),
                                   [](const graph::Term& term) { return term.metric == graph::Metric::kResponseTime; });
  if (chains.size() != static_cast<std::size_t>(terms)) return broken("not one chain a response time");
  RatePlan again = plan;
  fill_figures(again, app, costs, cores, chains);
  if (differ(again.objective, plan.objective)) return broken("the objective is not the sum of its terms");
  if (differ(again.relax_factor, plan.relax_factor) || again.relaxed.size() != plan.relaxed.size()) {
    return broken("bounds that do not hold are not named");
  }
  return Done{};
}

std::vector<std::vector<double>> stretched_costs(const graph::App& app, const model::CostTable& costs, double slack) {
  std::vector<std::vector<double>> stretched;
  for (const model::CostTable& on_kind : model::costs_by_kind(app, costs)) {
    std::vector<double> of_kind;
    for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
      const double cost = on_kind.subchain_total(app.graph, SubchainId(i)).count();
      of_kind.push_back(std::max(cost, kMinCost) / (1.0 - slack));
    }
    stretched.push_back(std::move(of_kind));
  }
  return stretched;
}

Millis output_period(const graph::Graph& graph, const graph::ChainElement& element) {
  Millis longest{0};
  for (const NodeId id : element.nodes) {
    if (const auto& period = graph.node(id).output_period) longest = std::max(longest, to_millis(*period));
  }
  return longest;
}

}  // namespace ctn::baselines
