#include "driver/planning_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "policy/planned.h"

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
      asked_(app),
      chosen_(options_.cpus),
      online_(options_.cpus),
      app_online_(app),
      measured_(app),
      hung_runs_(app.graph),
      clock_(TimePoint{}, app.scheduler),
      clocks_(app.graph.nodes().size()),
      memory_(options_.policy->make_memory()),
      power_(kinds_, app.kinds()),
      news_(app) {}

Status PlanningLoop::decide_first() {
  const policy::Policy& policy = *options_.policy;
  if (policy.needs_costs() && !options_.known_costs) return policy::costs_missing(policy);
  const model::CostTable costs = policy.needs_costs()
                                     ? *options_.known_costs
                                     : model::CostTable::assumed(app_.graph, app_.scheduler.bootstrap_cost);
  policy::Situation now = situation(costs, costs);
  const std::vector<NodeId> unknown = measured_.unknown();
  if (adapts()) now.assumed = unknown;
  std::optional<Result<policy::Decision>> decision;
  const PlanningTime took = options_.timer([&] { decision = policy.decide(now); });
  if (!*decision) return decision->error();
  if ((*decision)->plan && adapts()) (*decision)->plan->solve_time = took.elapsed;
  begin_with(std::move(**decision));
  return Done{};
}

void PlanningLoop::begin_with(policy::Decision decision) {
  decision_ = std::move(decision);
  if (decision_.plan) options_.slack = decision_.plan->slack;
  if (options_.policy->raises()) levels_.scheduled = os::Level::kBackground;
  rise();
}

bool PlanningLoop::rise() {
  const Levels before = levels_;
  levels_.dispatcher = std::max(before.dispatcher, decision_.dispatcher_level);
  if (options_.policy->raises()) levels_.unscheduled = std::max(before.unscheduled, decision_.unscheduled_level);
  return levels_.dispatcher > before.dispatcher || levels_.unscheduled > before.unscheduled;
}

record::Header PlanningLoop::record_header() const {
  record::Header header;
  header.scheduler = options_.policy->name();
  header.cpus = options_.cpus;
  if (decision_.plan) header.slack = options_.slack;
  header.stealing = options_.stealing;
  return header;
}

void PlanningLoop::begin(TimePoint start, PlanningHost& host) {
  clock_ = policy::ReplanClock(start, app_.scheduler, options_.policy->replan_every(app_.scheduler),
                               memory_ ? policy::kSavedForSearch : Nanos{0});
  in_force(adapts() ? PlanReason::kBootstrap : PlanReason::kStatic, host);
}

std::optional<record::CostChange> PlanningLoop::ran(const record::Run& run) {
  if (!hung_runs_.counts(run)) return std::nullopt;
  std::optional<record::CostChange> change = measured_.add(run, kinds_.of(run.on_cpu));
  if (change) cost_changed_ = true;
  return change;
}

void PlanningLoop::change(graph::App app, os::CpuSet cpus) {
  asked_ = std::move(app);
  chosen_ = std::move(cpus);
  app_online_ = kinds_.only_with(asked_, online_);
  memory_ = options_.policy->make_memory();
  asked_changed_ = true;
  next_cpu_check_ = {};
}

std::optional<Planned> PlanningLoop::plan(TimePoint now, PlanningHost& host) {
  if (!adapts()) return std::nullopt;
  const ControllerWork controllers = host.controller_work();
  step_cost_.saw(controllers.cpu, controllers.by_timer, controllers.by_event);
  const std::optional<PlanReason> why = due(now, host);
  if (!why) return std::nullopt;
  Planned planned;
  const Nanos work_before = memory_ ? memory_->work() : Nanos{0};
  const PlanningTime took = options_.timer([&] { planned = make_new_plan(*why, host); });
  if (planned.next && planned.next->plan) planned.next->plan->solve_time = took.elapsed;
  const Nanos work = memory_ ? memory_->work() - work_before : Nanos{0};
  planning_cpu_ += took.cpu;
  // Where the machine is faster than the one that work is counted for, the budget counts the work, so that what is
  // found does not depend on the machine's speed.
  clock_.made(now, *why, std::max(took.cpu, work), measured_.known());
  return planned;
}

// CPUs first: nothing can be followed on one that has gone. What was asked is planned for with them.
std::optional<PlanReason> PlanningLoop::due(TimePoint now, PlanningHost& host) {
  const bool asked = std::exchange(asked_changed_, false);
  if (check_cpus(now, host)) return PlanReason::kCpus;
  if (asked) return PlanReason::kAsked;
  if (std::exchange(cost_changed_, false)) clock_.changed(PlanReason::kChange);
  check_power(now, host);
  const std::optional<PlanReason> why =
      clock_.due(now, measured_.known(), memory_ && memory_->more_to_do(measured_.min_runs()));
  return why == PlanReason::kMeasured || options_.replan || !decision_.plan ? why : std::nullopt;
}

bool PlanningLoop::check_cpus(TimePoint now, PlanningHost& host) {
  if (now < next_cpu_check_) return false;
  next_cpu_check_ = now + kCpuCheckPeriod;
  const Result<os::CpuSet> usable = host.usable_cpus();
  if (!usable) return false;
  os::CpuSet online = os::common(chosen_, *usable);
  if (online.empty() && !std::exchange(no_cpus_, true)) {
    host.notice("cpus", fmt::format("of CPUs {}, none is online and allowed to the app's programs: it goes on as "
                                    "planned for {}, where the system lets it; give one back",
                                    os::to_string(chosen_), os::to_string(online_)));
  }
  if (!online.empty()) no_cpus_ = false;
  if (online == online_ || online.empty()) return false;
  online_ = std::move(online);
  app_online_ = kinds_.only_with(asked_, online_);
  memory_ = options_.policy->make_memory();
  host.notice("cpus", fmt::format("of CPUs {}, {} are online and allowed: planning for these", os::to_string(chosen_),
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

Planned PlanningLoop::make_new_plan(PlanReason why, PlanningHost& host) {
  const std::vector<NodeId> unknown = measured_.unknown();
  const model::CostTable costs = with_assumed(measured_.costs(app_.scheduler.bootstrap_cost), unknown, why);
  const model::CostTable typical = with_assumed(measured_.typical_costs(app_.scheduler.bootstrap_cost), unknown, why);
  policy::Situation now = situation(costs, typical);
  now.assumed = unknown;
  now.why = why;
  now.periodic = why == PlanReason::kPeriodic ? clock_.periodic() + 1 : 0;
  now.memory = memory_.get();
  trial::MeasuredRuns runs;
  if (memory_) {
    runs = measured_.runs();
    now.runs = &runs;
    now.min_runs = measured_.min_runs();
    now.step_factor = step_cost_.factor();
  }
  Result<std::optional<policy::Decision>> decision = policy::replacement(*options_.policy, now, decision_);
  Planned planned{.reason = why};
  if (decision && *decision) {
    planned.next = std::move(**decision);
  } else if (names_missing_cpu()) {
    planned.next = policy::rates_only(decision_, online_);
    host.notice("replan-failed",
                fmt::format("{}; what was planned needs CPUs that are gone: until there is a plan, nodes run at the "
                            "rates of the last one at most, as ordinary threads on CPUs {}",
                            decision ? "there is no plan for the CPUs that are left" : decision.error().message(),
                            os::to_string(online_)));
  } else if (!decision && !plan_failed_) {
    // One notice, not one for each attempt.
    host.notice("replan-failed", decision.error().message());
  }
  plan_failed_ = !decision;
  if (planned.next) planned.next->assignment = on_given_cores(std::move(planned.next->assignment));
  return planned;
}

// Nodes that have not run, and those of programs that are not there, are planned for as though they ran: at what they
// cost when they last did, else at what they are assumed to. They may come at any time, a program that was started
// again within a second (docs/decisions/0020), and then find their place without a plan that moves all others
// twice. What they leave unused meanwhile goes to those that are there where they share a core: elastic frames pass
// over them, and the members of a frame divide it. Only cores that would be all theirs are left unused.
//
// While a plan is compared with the one in force, both are made at the same guess: one that was lowered for the sake of
// exact rates (policy/planned.h) stays so.
model::CostTable PlanningLoop::with_assumed(model::CostTable costs, const std::vector<NodeId>& unknown,
                                            PlanReason why) const {
  if (!decision_.plan || policy::is_unconditional(why)) return costs;
  for (const plan::AssumedCost& assumed : decision_.plan->assumed) {
    if (std::find(unknown.begin(), unknown.end(), assumed.node) == unknown.end()) continue;
    costs.set(assumed.node, model::CostProfile::assumed(assumed.cost));
  }
  return costs;
}

std::optional<double> PlanningLoop::hand_set_hz() const {
  const std::vector<policy::SubchainPlace>& places = decision_.assignment.places;
  if (options_.policy->follows_plan() || places.empty()) return std::nullopt;
  return Rate::every(places.front().pacing.period).hertz();
}

bool PlanningLoop::names_missing_cpu() const {
  const std::vector<policy::SubchainPlace>& places = decision_.assignment.places;
  return std::any_of(places.begin(), places.end(), [&](const policy::SubchainPlace& place) {
    const std::vector<int>& cpus = place.cpus.cpus();
    return !std::all_of(cpus.begin(), cpus.end(), [&](int cpu) { return online_.contains(cpu); });
  });
}

void PlanningLoop::adopt(Planned planned, PlanningHost& host) {
  if (planned.next) {
    decision_ = std::move(*planned.next);
    in_force(planned.reason, host);
  }
  if (planned.reason == PlanReason::kCpus) host.cpus_changed(online_);
}

void PlanningLoop::in_force(PlanReason reason, PlanningHost& host) {
  if (rise()) host.raise(levels_);
  host.in_force(decision_, reason);
  if (!decision_.plan) return;
  for (const PlanNews::Notice& notice : news_.in_force(*decision_.plan)) host.notice(notice.kind, notice.detail);
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
          .frames = options_.frames,
          .clocks = clocks_};
}

void PlanningLoop::clock_known(NodeId node, const Ticks& ticks) {
  measured_.set_clock(node, ticks);
  clocks_[node.index()] = ticks;
}

}  // namespace ctn::driver
