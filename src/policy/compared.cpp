#include "policy/compared.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "config/cost_file.h"
#include "planner/compared/davare.h"
#include "planner/compared/picas.h"
#include "planner/compared/reservations.h"
#include "planner/compared/verucchi.h"
#include "policy/levels.h"
#include "policy/replan.h"

namespace ctn::policy {
namespace {

os::CpuSet one_cpu(const os::CpuSet& cpus, int core) { return os::CpuSet{cpus.cpus()[static_cast<std::size_t>(core)]}; }

// A run at a low priority may well take all of its period, and longer where costs are more than was thought.
Nanos hang_after(Nanos period) { return std::max(kShortestHang, kHangMultiple * period); }

}  // namespace

Result<model::CostTable> GivenCosts::of(const Situation& situation) const {
  if (missing()) return situation.costs;
  return config::load_costs(file_, situation.app);
}

Result<Decision> PicasPolicy::decide(const Situation& situation) const {
  const graph::App& app = situation.app;
  const Result<std::vector<Rate>> set = rates(app);
  if (!set) return set.error();
  const Result<model::CostTable> costs = costs_.of(situation);
  if (!costs) return costs.error();
  const planner::ChainAware found =
      planner::assign_by_chains(app, *costs, *set, static_cast<int>(situation.cpus.size()));
  Decision decision = at(*set, situation.cpus);
  std::size_t ranks = 0;
  for (const int rank : found.rank) ranks += rank >= 0 ? 1 : 0;
  if (Status fits = rise_above(decision, ranks, "nodes"); !fits) return fits.error();
  for (std::size_t i = 0; i < decision.assignment.places.size(); ++i) {
    SubchainPlace& place = decision.assignment.places[i];
    place.cpus = one_cpu(situation.cpus, found.core[i]);
    place.pacing.hang_after = hang_after(place.pacing.period);
    for (const NodeId node : app.graph.subchain(SubchainId(i)).nodes) {
      place.levels.push_back(os::fixed_level(found.rank[node.index()]));
    }
    place.level = place.levels.front();
  }
  return decision;
}

Result<Decision> DeadlinePolicy::decide(const Situation& situation) const {
  const graph::App& app = situation.app;
  const Result<std::vector<Rate>> set = rates(app);
  if (!set) return set.error();
  const Result<model::CostTable> costs = costs_.of(situation);
  if (!costs) return costs.error();
  const planner::Reservations found = planner::reserve(app, *costs, *set, static_cast<int>(situation.cpus.size()));
  Decision decision = at(*set, situation.cpus);
  for (std::size_t i = 0; i < decision.assignment.places.size(); ++i) {
    SubchainPlace& place = decision.assignment.places[i];
    place.pacing.period = found.periods[i];
    place.threads = 1;  // a reservation is for one
    place.pacing.hang_after = hang_after(place.pacing.period);
    for (const NodeId node : app.graph.subchain(SubchainId(i)).nodes) {
      place.reservations.push_back(found.nodes[node.index()]);
    }
  }
  decision.unscheduled_level = os::Level::kUnscheduled;
  decision.dispatcher_level = os::Level::kDispatcher;
  return decision;
}

Result<Decision> RatesPolicy::decide(const Situation& situation) const {
  const Result<model::CostTable> costs = costs_.of(situation);
  if (!costs) return costs.error();
  const Result<planner::RatePlan> plan =
      method_(situation.app, *costs, {static_cast<int>(situation.cpus.size()), situation.slack, 0});
  if (!plan) return plan.error();
  Decision decision;
  decision.assignment.cores.resize(situation.cpus.size());
  if (Status fits = rise_above(decision, plan->subchains.size(), "subchains"); !fits) return fits.error();
  for (const planner::TaskPlan& task : plan->subchains) {
    SubchainPlace& place = decision.assignment.places.emplace_back();
    place.cpus = one_cpu(situation.cpus, task.core);
    place.level = os::fixed_level(task.priority - 1);
    place.pacing.period = std::max(to_nanos(task.period), dispatch::kShortestPeriod);
    place.pacing.hang_after = hang_after(place.pacing.period);
  }
  return decision;
}

std::shared_ptr<const Policy> make_compared_policy(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon != std::string_view::npos && colon + 1 == text.size()) return nullptr;
  const std::string name(text.substr(0, colon));
  const GivenCosts costs(colon == std::string_view::npos ? "" : std::string(text.substr(colon + 1)));
  if (name == "picas") return std::make_shared<PicasPolicy>(costs);
  if (name == "deadline") return std::make_shared<DeadlinePolicy>(costs);
  if (name == "davare") return std::make_shared<RatesPolicy>(name, planner::plan_by_davare, costs);
  if (name == "verucchi") return std::make_shared<RatesPolicy>(name, planner::plan_by_verucchi, costs);
  return nullptr;
}

}  // namespace ctn::policy
