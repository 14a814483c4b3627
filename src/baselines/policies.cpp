#include "baselines/policies.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "baselines/davare.h"
#include "baselines/picas.h"
#include "baselines/reservations.h"
#include "baselines/verucchi.h"
#include "policy/levels.h"
#include "policy/replan.h"

namespace ctn::baselines {
namespace {

using policy::Decision;
using policy::Situation;
using policy::SubchainPlace;

os::CpuSet one_cpu(const os::CpuSet& cpus, int core) { return os::CpuSet{cpus.cpus()[static_cast<std::size_t>(core)]}; }

// A run at a low priority may well take all of its period, and longer where costs are more than was thought.
Nanos hang_after(Nanos period) { return std::max(policy::kShortestHang, policy::kHangMultiple * period); }

const model::CostTable& costs_of(const GivenCosts& given, const Situation& situation) {
  return given ? *given : situation.costs;
}

}  // namespace

Result<Decision> PicasPolicy::decide(const Situation& situation) const {
  const graph::App& app = situation.app;
  const Result<std::vector<Rate>> set = rates(app);
  if (!set) return set.error();
  const ChainAware found =
      assign_by_chains(app, costs_of(costs_, situation), *set, static_cast<int>(situation.cpus.size()));
  Decision decision = at(*set, situation.cpus);
  std::size_t ranks = 0;
  for (const int rank : found.rank) ranks += rank >= 0 ? 1 : 0;
  if (Status fits = policy::rise_above(decision, ranks, "nodes"); !fits) return fits.error();
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
  const Result<std::vector<Rate>> set = rates(situation.app);
  if (!set) return set.error();
  const Reservations found = reservations_for(situation, *set);
  Decision decision = at(*set, situation.cpus);
  for (std::size_t i = 0; i < decision.assignment.places.size(); ++i) {
    SubchainPlace& place = decision.assignment.places[i];
    place.pacing.period = found.periods[i];
    place.threads = 1;  // a reservation is for one
    place.pacing.hang_after = hang_after(place.pacing.period);
  }
  decision.unscheduled_level = os::Level::kUnscheduled;
  decision.dispatcher_level = os::Level::kDispatcher;
  return decision;
}

Result<std::vector<sim::Reservation>> DeadlinePolicy::reserve(const Situation& situation) const {
  const Result<std::vector<Rate>> set = rates(situation.app);
  if (!set) return set.error();
  return reservations_for(situation, *set).nodes;
}

Reservations DeadlinePolicy::reservations_for(const Situation& situation, const std::vector<Rate>& rates) const {
  return baselines::reserve(situation.app, costs_of(costs_, situation), rates, static_cast<int>(situation.cpus.size()));
}

Result<Decision> RatesPolicy::decide(const Situation& situation) const {
  const Result<RatePlan> plan = method_(situation.app, costs_of(costs_, situation),
                                        {static_cast<int>(situation.cpus.size()), situation.slack, 0});
  if (!plan) return plan.error();
  Decision decision;
  decision.assignment.cores.resize(situation.cpus.size());
  if (Status fits = policy::rise_above(decision, plan->subchains.size(), "subchains"); !fits) return fits.error();
  for (const TaskPlan& task : plan->subchains) {
    SubchainPlace& place = decision.assignment.places.emplace_back();
    place.cpus = one_cpu(situation.cpus, task.core);
    place.level = os::fixed_level(task.priority - 1);
    place.pacing.period = std::max(to_nanos(task.period), dispatch::kShortestPeriod);
    place.pacing.hang_after = hang_after(place.pacing.period);
  }
  return decision;
}

bool is_baseline(std::string_view method) {
  constexpr std::array<std::string_view, 4> kMethods{"picas", "deadline", "davare", "verucchi"};
  return std::find(kMethods.begin(), kMethods.end(), method) != kMethods.end();
}

Baseline make_baseline(std::string_view method, std::string name, GivenCosts costs) {
  assert(is_baseline(method));
  if (method == "picas") return {std::make_shared<PicasPolicy>(std::move(name), std::move(costs))};
  if (method == "davare") return {std::make_shared<RatesPolicy>(std::move(name), plan_by_davare, std::move(costs))};
  if (method == "verucchi") return {std::make_shared<RatesPolicy>(std::move(name), plan_by_verucchi, std::move(costs))};
  auto policy = std::make_shared<const DeadlinePolicy>(std::move(name), std::move(costs));
  return {policy, [policy](const Situation& situation) { return policy->reserve(situation); }};
}

}  // namespace ctn::baselines
