#include "runtime/scheduler.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ctn::runtime {
namespace {

// How soon it is noticed that a CPU has gone or come back.
constexpr Nanos kLookAtCpus = std::chrono::milliseconds{100};

}  // namespace

Scheduler::~Scheduler() {
  release();
  if (housekeeper_) static_cast<void>(finish());
}

Status Scheduler::start() {
  const std::size_t subchains = app_.graph.subchains().size();
  for (std::size_t index = 0; index < subchains; ++index) in_force_[index] = complete(app_.graph.subchains()[index]);
  spawn_controllers();
  for (std::uint32_t ready = 0; ready < threads_.size();) {
    os_.wait(ready_, ready, kNever);
    ready = ready_.load(std::memory_order_acquire);
  }
  if (Status placed = place_controllers(); !placed) {
    abandoned_.store(true);
    release();
    return placed;
  }
  go_.store(1, std::memory_order_release);
  os_.wake(go_);
  housekeeper_thread_ =
      os_.spawn("catan-house", [this] { housekeeper_->run(controllers_, [this](TimePoint now) { replan(now); }); });
  return Done{};
}

void Scheduler::release() {
  {
    const std::lock_guard lock(mutex_);
    released_ = true;
  }
  if (housekeeper_thread_) {
    housekeeper_->stop();
    housekeeper_thread_->join();
    housekeeper_thread_.reset();
  }
  // Everything is given back while the nodes' threads still live; what runs are under way end at the ordinary level.
  // Before the controllers end, since they end sooner then; and once more after, since until then they set levels.
  if (enforcer_) enforcer_->give_all_back();
  ready_cpus_.reset();
  go_.store(1, std::memory_order_release);
  os_.wake(go_);
  for (const auto& controller : controllers_) controller->stop();
  for (const auto& thread : threads_) thread->join();
  threads_.clear();
  if (enforcer_) enforcer_->release_all();
}

Status Scheduler::finish() { return housekeeper_->finish(controllers_); }

// From the cores that a plan knows, which are those that are there, to all that were given, which have the core
// threads.
Assignment Scheduler::on_all_cores(Assignment assignment) const {
  if (there_ == cpus_) return assignment;
  const std::vector<int>& given = cpus_.cpus();
  std::vector<std::size_t> position;
  for (const int cpu : there_.cpus()) {
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

Assignment Scheduler::assignment() const {
  Assignment assignment = decision_.assignment;
  leave_out_absent(assignment, in_force_);
  return assignment;
}

void Scheduler::publish(Assignment assignment) {
  places_ = assignment.places;
  for (std::size_t index = 0; index < places_.size(); ++index) {
    SignalCell& signal = region_.signal(SubchainId(index));
    signal.period.store(period_of(SubchainId(index)).count(), std::memory_order_relaxed);
    signal.threads.store(places_[index].threads, std::memory_order_relaxed);
  }
  controls_->board.publish(std::move(assignment));
  controls_->nudge_all();
}

// What nodes go on at without a scheduler.
Nanos Scheduler::period_of(SubchainId subchain) const {
  const policy::SubchainPlace& place = places_[subchain.index()];
  return place.core < 0 ? place.pacing.period : to_nanos(decision_.plan->subchains[subchain.index()].period);
}

Rate Scheduler::source_rate() const {
  if (places_.front().core < 0) return Rate::every(places_.front().pacing.period);
  const plan::Plan& plan = *decision_.plan;
  return Rate::every(plan.expected ? plan.expected->subchains.front().period : plan.subchains.front().period);
}

policy::Situation Scheduler::situation(const graph::App& app, const model::CostTable& costs,
                                       const model::CostTable& typical) const {
  return {.app = app,
          .cpus = there_,
          .costs = costs,
          .typical = typical,
          .slack = slack_,
          .stealing = options_.stealing,
          .frames = options_.frames};
}

Result<policy::Decision> Scheduler::decide(const model::CostTable& costs) {
  const TimePoint begin = os_.now();
  const graph::App app = kinds_.only_with(app_, there_);
  Result<policy::Decision> decision = options_.policy->decide(situation(app, costs, costs));
  if (decision) complete(*decision, begin);
  return decision;
}

// What only the runtime knows of a decision that it began to make at `begin`.
void Scheduler::complete(policy::Decision& decision, TimePoint begin) const {
  decision.assignment = on_all_cores(std::move(decision.assignment));
  if (decision.plan && options_.policy->adapts()) decision.plan->solve_time = os_.now() - begin;
}

void Scheduler::replan(TimePoint now) {
  settle_members();
  follow_cpus(now);
  if (!adaptation_) return;
  const std::optional<policy::PlanReason> due = adaptation_->due(now, *housekeeper_);
  if (!due || (*due != policy::PlanReason::kMeasured && !options_.replan)) return;
  adaptation_->plan(now, *due, *housekeeper_, [&] { make_plan_anew(*due); });
}

void Scheduler::follow_cpus(TimePoint now) {
  if (!options_.policy->adapts() || now < next_look_) return;
  next_look_ = now + kLookAtCpus;
  const Result<os::CpuSet> online = os_.online_cpus();
  if (!online) return;
  const os::CpuSet there = os::common(cpus_, *online);
  if (there == there_ || there.empty()) return;
  there_ = there;
  housekeeper_->notice("cpus", fmt::format("of CPUs {}, {} are online: planning for these", os::to_string(cpus_),
                                           os::to_string(there_)));
  adaptation_->plan(now, policy::PlanReason::kCpus, *housekeeper_,
                    [this] { make_plan_anew(policy::PlanReason::kCpus); });
  place_anew();
}

// Threads that belong to no subchain: the system has moved those whose CPU went, and does not move them back.
void Scheduler::place_anew() {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    if (!app_.graph.nodes()[index].unscheduled) continue;
    links_[index]->for_each_thread([&](os::ThreadId thread) { enforcer_->move_now(thread, there_); });
  }
  for (std::size_t index = 0; index < controller_ids_.size(); ++index) {
    const os::CpuSet cpus = cpus_of_controller(index);
    if (!cpus.empty()) enforcer_->move_now(controller_ids_[index], cpus);
  }
}

void Scheduler::make_plan_anew(policy::PlanReason reason) {
  const Millis unmeasured = app_.scheduler.bootstrap_cost;
  const model::CostTable costs = housekeeper_->costs(unmeasured);
  const model::CostTable typical = housekeeper_->typical_costs(unmeasured);
  const graph::App app = kinds_.only_with(app_, there_);
  const TimePoint begin = os_.now();
  Result<std::optional<policy::Decision>> decision =
      policy::replacement(*options_.policy, situation(app, costs, typical), decision_, reason);
  if (!decision) {
    if (!replan_failed_) housekeeper_->notice("replan-failed", decision.error().message());
    replan_failed_ = true;
    return;
  }
  replan_failed_ = false;
  if (!*decision) return;
  complete(**decision, begin);
  adopt(std::move(**decision), reason);
}

void Scheduler::adopt(policy::Decision decision, policy::PlanReason reason) {
  decision_ = std::move(decision);
  publish(assignment());
  housekeeper_->plan_in_force(*decision_.plan, source_rate(), to_string(reason));
}

Snapshot Scheduler::snapshot() const {
  Snapshot snapshot;
  snapshot.policy = options_.policy->name();
  if (!housekeeper_) return snapshot;
  snapshot.real_time = enforcer_->real_time();
  std::optional<double> hand_set_hz;
  if (!options_.policy->follows_plan()) hand_set_hz = source_rate().hertz();
  housekeeper_->fill(snapshot, hand_set_hz);
  return snapshot;
}

}  // namespace ctn::runtime
