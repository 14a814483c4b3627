#include "driver/planning_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace ctn::driver {
namespace {

using policy::PlanReason;

// How soon it is noticed that a CPU has gone or come back.
constexpr Nanos kCpuCheckPeriod = std::chrono::milliseconds{100};
constexpr Nanos kPowerCheckPeriod = std::chrono::seconds{1};

}  // namespace

PlanningLoop::PlanningLoop(const graph::App& app, PlanningOptions options)
    : app_(app),
      options_(std::move(options)),
      kinds_(app, options_.cpus),
      online_(options_.cpus),
      app_online_(app),
      measured_(app),
      hung_runs_(app.graph),
      clock_(TimePoint{}, app.scheduler),
      power_(kinds_, app.kinds()) {}

Status PlanningLoop::decide_first() {
  const policy::Policy& policy = *options_.policy;
  if (policy.needs_costs() && !options_.known_costs) {
    return Error::caller(
        fmt::format("scheduler '{}' decides once, by compute times that are known before", policy.name()),
        fmt::format("say which: {}:COSTS.yaml", policy.name()));
  }
  const model::CostTable costs =
      policy.needs_costs() ? *options_.known_costs : model::CostTable(app_.graph, app_.scheduler.bootstrap_cost);
  std::optional<Result<policy::Decision>> decision;
  const PlanningTime took = options_.timer([&] { decision = policy.decide(situation(costs, costs)); });
  if (!*decision) return decision->error();
  if ((*decision)->plan && adapts()) (*decision)->plan->solve_time = took.elapsed;
  begin_with(std::move(**decision));
  return Done{};
}

void PlanningLoop::begin_with(policy::Decision decision) {
  decision_ = std::move(decision);
  if (decision_.plan) options_.slack = decision_.plan->slack;
}

void PlanningLoop::begin(TimePoint start, PlanningHost& host) {
  clock_ = policy::ReplanClock(start, app_.scheduler);
  host.in_force(decision_, adapts() ? PlanReason::kBootstrap : PlanReason::kStatic);
}

std::optional<record::CostChange> PlanningLoop::ran(const record::Run& run) {
  if (!hung_runs_.counts(run)) return std::nullopt;
  std::optional<record::CostChange> change = measured_.add(run, kinds_.of(run.on_cpu));
  if (change) {
    cost_changed_ = true;
    ++cost_changes_;
  }
  return change;
}

bool PlanningLoop::plan(TimePoint now, PlanningHost& host) {
  if (!adapts()) return false;
  const std::optional<PlanReason> why = due(now, host);
  if (!why) return false;
  const PlanningTime took = options_.timer([&] { make_new_plan(*why, host); });
  if (next_) next_->plan->solve_time = took.elapsed;
  clock_.made(now, *why, took.cpu);
  return true;
}

// CPUs first: nothing can be followed on one that has gone.
std::optional<PlanReason> PlanningLoop::due(TimePoint now, PlanningHost& host) {
  if (check_cpus(now, host)) return PlanReason::kCpus;
  if (std::exchange(cost_changed_, false)) clock_.changed(PlanReason::kChange);
  check_power(now, host);
  const std::optional<PlanReason> why = clock_.due(now, measured_.all_measured());
  return why == PlanReason::kMeasured || options_.replan ? why : std::nullopt;
}

bool PlanningLoop::check_cpus(TimePoint now, PlanningHost& host) {
  if (now < next_cpu_check_) return false;
  next_cpu_check_ = now + kCpuCheckPeriod;
  const Result<os::CpuSet> all_online = host.online_cpus();
  if (!all_online) return false;
  os::CpuSet online = os::common(options_.cpus, *all_online);
  if (online == online_ || online.empty()) return false;
  online_ = std::move(online);
  app_online_ = kinds_.only_with(app_, online_);
  cpus_changed_ = true;
  host.notice("cpus", fmt::format("of CPUs {}, {} are online: planning for these", os::to_string(options_.cpus),
                                  os::to_string(online_)));
  return true;
}

void PlanningLoop::check_power(TimePoint now, PlanningHost& host) {
  if (now < next_power_check_) return;
  next_power_check_ = now + kPowerCheckPeriod;
  const std::optional<PowerChange> change = power_.update(host.power_state());
  if (!change) return;
  for (std::size_t kind = 0; kind < change->factors.size(); ++kind) {
    const std::optional<double> factor = change->factors[kind];
    factor ? measured_.rescale(kind, *factor) : measured_.invalidate(kind);
  }
  host.notice("power", change->what);
  clock_.changed(PlanReason::kPower);
}

void PlanningLoop::make_new_plan(PlanReason why, PlanningHost& host) {
  const Millis unmeasured = app_.scheduler.bootstrap_cost;
  const model::CostTable costs = measured_.costs(unmeasured);
  const model::CostTable typical = measured_.typical_costs(unmeasured);
  Result<std::optional<policy::Decision>> decision =
      policy::replacement(*options_.policy, situation(costs, typical), decision_, why);
  if (!decision) {
    // One notice, not one for each attempt.
    if (!std::exchange(plan_failed_, true)) host.notice("replan-failed", decision.error().message());
    return;
  }
  plan_failed_ = false;
  if (!*decision) return;
  next_ = std::move(**decision);
  next_->assignment = on_given_cores(std::move(next_->assignment));
  next_reason_ = why;
}

void PlanningLoop::adopt(PlanningHost& host) {
  if (std::optional<policy::Decision> next = std::exchange(next_, std::nullopt)) {
    adopt(std::move(*next), next_reason_, host);
  }
  if (std::exchange(cpus_changed_, false)) host.cpus_changed(online_);
}

void PlanningLoop::adopt(policy::Decision decision, PlanReason reason, PlanningHost& host) {
  decision_ = std::move(decision);
  host.in_force(decision_, reason);
}

// From the cores that a plan knows, which are those that are online, to all that were given.
policy::Assignment PlanningLoop::on_given_cores(policy::Assignment assignment) const {
  if (online_ == options_.cpus) return assignment;
  const std::vector<int>& given = options_.cpus.cpus();
  std::vector<std::size_t> position;
  for (const int cpu : online_.cpus()) {
    position.push_back(static_cast<std::size_t>(std::find(given.begin(), given.end(), cpu) - given.begin()));
  }
  std::vector<dispatch::SharedCoreSchedule> cores(given.size());
  for (std::size_t core = 0; core < position.size(); ++core) {
    cores[position[core]] = std::move(assignment.cores[core]);
  }
  assignment.cores = std::move(cores);
  for (policy::SubchainPlace& place : assignment.places) {
    if (place.core >= 0) place.core = static_cast<int>(position[static_cast<std::size_t>(place.core)]);
  }
  return assignment;
}

policy::Situation PlanningLoop::situation(const model::CostTable& costs, const model::CostTable& typical) const {
  return {.app = app_online_,
          .cpus = online_,
          .costs = costs,
          .typical = typical,
          .slack = options_.slack,
          .stealing = options_.stealing,
          .frames = options_.frames};
}

}  // namespace ctn::driver
