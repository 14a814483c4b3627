#include "runtime/engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "config/app_file.h"
#include "plan/json.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/recost.h"
#include "plan/validate.h"
#include "planner/planner.h"
#include "runtime/core_thread.h"
#include "runtime/trigger_thread.h"

namespace ctn::runtime {
namespace {

// Between the end of the bootstrap and the first sample that counts: the first measured plan comes into force and what
// was under way under the old one ends.
constexpr Nanos kSettle = std::chrono::milliseconds{500};
// More than the kernel keeps for ordinary threads, so that it never has to take it by force.
constexpr double kSlackMargin = 0.01;
// How soon it is noticed that a CPU has gone or come back.
constexpr Nanos kLookAtCpus = std::chrono::milliseconds{100};

// All problems with the requested CPUs, or the CPUs to use.
Result<os::CpuSet> choose_cpus(os::Os& os, const os::CpuSet& asked) {
  Result<os::Topology> topology = os.topology();
  if (!topology) return topology.error();
  const os::CpuSet online = topology->online();
  if (asked.empty()) {
    Result<os::CpuSet> mine = os.affinity(os.current_thread());
    return mine ? mine : online;
  }
  std::vector<Problem> problems;
  for (const int cpu : asked.cpus()) {
    if (online.contains(cpu)) continue;
    problems.push_back({{}, {}, fmt::format("CPU {} is not online", cpu), "choose from " + os::to_string(online)});
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return asked;
}

// What runs cost is measured on whatever core they are on, and not yet told apart.
Error cores_must_be_alike() {
  return Error::caller("the app lists kinds of cores, which this version plans for but does not measure apart",
                       "remove cores from the app file, and give the session CPUs of one kind");
}

}  // namespace

Result<std::unique_ptr<Engine>> Engine::create(graph::App app, os::Os& os, EngineOptions options) {
  if (!app.core_kinds.empty()) return cores_must_be_alike();
  Result<os::CpuSet> cpus = choose_cpus(os, options.cpus);
  if (!cpus) return cpus.error();
  return std::unique_ptr<Engine>(new Engine(std::move(app), os, std::move(options), std::move(*cpus)));
}

Engine::Engine(graph::App app, os::Os& os, EngineOptions options, os::CpuSet cpus)
    : app_(std::move(app)), os_(os), options_(std::move(options)), cpus_(std::move(cpus)), wiring_(app_, os_) {
  app_.scheduler.frames = options_.frames.value_or(app_.scheduler.frames);
  there_ = cpus_;
}

Engine::~Engine() { static_cast<void>(stop()); }

Status Engine::start() {
  if (started_) return Error::caller("the session was started before", "open another");
  if (Status ready = prepare(); !ready) return ready;
  started_ = true;
  if (Status placed = spawn_and_place(); !placed) {
    abandoned_.store(true);
    end_threads();
    return placed;
  }
  go_.store(1, std::memory_order_release);
  os_.wake(go_);
  housekeeper_thread_ =
      os_.spawn("catan-house", [this] { housekeeper_->run(controllers_, [this](TimePoint now) { replan(now); }); });
  return Done{};
}

Status Engine::prepare() {
  if (Status wired = wiring_.check(); !wired) return wired;
  const os::RealTimeFacts facts = os_.real_time_facts();
  const bool real_time = options_.policy.raises() && facts.permitted;
  slack_ = app_.scheduler.slack.value_or(std::max(graph::kDefaultSlack, facts.reserved + kSlackMargin));
  if (Status assigned = make_first_assignment(); !assigned) return assigned;

  const TimePoint start = os_.now();
  const TimePoint warm_from = start + app_.scheduler.bootstrap + kSettle;
  enforcer_ = std::make_unique<Enforcer>(os_, real_time,
                                         [this](const std::string& why) { housekeeper_->notice("rates-only", why); });
  std::unique_ptr<record::Writer> writer;
  if (Status opened = open_record(start, warm_from, writer); !opened) return opened;
  housekeeper_ = std::make_unique<Housekeeper>(app_, os_, wiring_, warm_from, std::move(writer), options_.on_notice);
  if (options_.policy.raises() && !facts.permitted) housekeeper_->notice("rates-only", facts.why_not);
  if (real_time) keep_cpus_ready();
  if (plan_) {
    const bool is_static = options_.policy.kind == Policy::Kind::kStatic;
    if (!is_static) replan_clock_.emplace(start, app_.scheduler);
    housekeeper_->plan_in_force(*plan_, source_rate(), is_static ? "static" : "bootstrap");
  }
  return Done{};
}

void Engine::keep_cpus_ready() {
  Result<std::unique_ptr<os::ReadyCpus>> ready = os_.keep_cpus_ready();
  if (ready) {
    ready_cpus_ = std::move(*ready);
  } else {
    housekeeper_->notice("idle-cpus", ready.error().message());
  }
}

Status Engine::open_record(TimePoint start, TimePoint warm_from, std::unique_ptr<record::Writer>& writer) {
  if (options_.record.empty()) return Done{};
  record::Header header;
  header.scheduler = options_.policy.name;
  header.cpus = cpus_;
  header.host = os_.host_facts();
  header.real_time = enforcer_->real_time();
  if (plan_) header.slack = slack_;
  header.started = start;
  header.warm_up = warm_from - start;
  header.note = options_.note;
  Result<std::unique_ptr<record::Writer>> created = record::Writer::create(options_.record, app_, header);
  if (!created) return created.error();
  writer = std::move(*created);
  return Done{};
}

Status Engine::make_first_assignment() {
  if (!options_.policy.follows_plan()) return place_by_hand();
  const model::CostTable unmeasured(app_.graph, app_.scheduler.bootstrap_cost);
  Result<plan::Plan> plan =
      options_.policy.kind == Policy::Kind::kStatic ? read_plan() : make_plan(unmeasured, unmeasured);
  if (!plan) return plan.error();
  plan_ = std::move(*plan);
  slack_ = plan_->slack;
  places_ = assignment().places;
  return Done{};
}

// A plan that is given is taken at its word: at which compute times it was made is not known.
Result<plan::Plan> Engine::read_plan() const {
  const Result<std::string> text = config::read_text(options_.policy.plan);
  if (!text) return text.error();
  Result<plan::Plan> plan = plan::from_json(*text, app_, options_.policy.plan);
  if (!plan) return plan;
  const auto is_exact = [&](const plan::Slot& slot) {
    return plan::period_limits(app_.graph, slot.subchain).exact.has_value();
  };
  for (plan::CorePlan& core : plan->cores) {
    // Where a rate is exact, frames are fixed whatever is asked.
    if (options_.frames && std::none_of(core.slots.begin(), core.slots.end(), is_exact)) core.frames = *options_.frames;
  }
  if (Status valid = plan::validate_layout(*plan, app_, static_cast<int>(cpus_.size())); !valid) return valid.error();
  return plan;
}

// By hand-set rates. With fixed priorities those of the app's order of stealing, nodes that run by themselves above
// them, and who triggers above all.
Status Engine::place_by_hand() {
  const Result<std::vector<Rate>> rates = hand_set_rates(options_.policy, app_);
  if (!rates) return rates.error();
  const bool fixed = options_.policy.kind == Policy::Kind::kFifo;
  const auto count = static_cast<int>(app_.steal.priority.size());
  if (fixed && count + 2 > os::kFixedLevels) {
    return Error::caller(fmt::format("{} subchains are more than there are fixed priorities", count),
                         "use another scheduler");
  }
  places_.clear();
  for (const Rate rate : *rates) {
    places_.push_back({-1, cpus_, {.period = to_nanos(rate.period()), .hang_after = fixed ? kShortestHang : Nanos{0}}});
  }
  for (int rank = 0; fixed && rank < count; ++rank) {
    const SubchainId id = app_.steal.priority[static_cast<std::size_t>(count - 1 - rank)];
    places_[id.index()].level = os::fixed_level(rank);
  }
  return Done{};
}

os::Level Engine::level_of_unscheduled() const {
  if (options_.policy.kind != Policy::Kind::kFifo) return plan_ ? os::Level::kUnscheduled : os::Level::kOrdinary;
  return os::fixed_level(static_cast<int>(places_.size()));
}

os::Level Engine::level_of_controllers() const {
  if (options_.policy.kind != Policy::Kind::kFifo) return plan_ ? os::Level::kDispatcher : os::Level::kOrdinary;
  return os::fixed_level(static_cast<int>(places_.size()) + 1);
}

// From the cores that a plan knows, which are those that are there, to all that were given, which have the core
// threads.
Assignment Engine::on_all_cores(Assignment assignment) const {
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
  for (SubchainPlace& place : assignment.places) {
    if (place.core >= 0) place.core = static_cast<int>(position[static_cast<std::size_t>(place.core)]);
  }
  return assignment;
}

Assignment Engine::assignment() const {
  if (plan_) return on_all_cores(assignment_of(app_, *plan_, there_, {.stealing = options_.stealing}));
  return {0, places_, std::vector<dispatch::SharedCoreSchedule>(cpus_.size())};
}

void Engine::publish(Assignment assignment) {
  places_ = assignment.places;
  controls_->board.publish(std::move(assignment));
  controls_->nudge_all();
}

Rate Engine::source_rate() const {
  if (places_.front().core < 0) return Rate::every(places_.front().pacing.period);
  const Millis planned = plan_->subchains.front().period;
  return Rate::every(plan_->expected ? plan_->expected->subchains.front().period : planned);
}

Result<plan::Plan> Engine::make_plan(const model::CostTable& costs, const model::CostTable& typical) {
  const TimePoint begin = os_.now();
  Result<plan::Plan> plan =
      planner::make_plan(app_, costs, {.cores = static_cast<int>(there_.size()), .slack = slack_});
  if (!plan) return plan;
  plan->solve_time = os_.now() - begin;
  plan->expected = plan::expect(*plan, app_, typical);
  return plan;
}

Status Engine::spawn_and_place() {
  spawn_nodes();
  const std::size_t node_threads = threads_.size();
  wait_until_ready(node_threads);
  if (Status placed = place_nodes(); !placed) return placed;

  spawn_controllers();
  wait_until_ready(threads_.size());
  return place_controllers();
}

void Engine::spawn_controllers() {
  const std::size_t subchains = app_.graph.subchains().size();
  subchains_ = wiring_.subchains();
  controls_ = std::make_unique<Controls>(os_, *enforcer_, subchains, cpus_.size());
  for (Handover& handover : controls_->handovers) handover.put({});
  publish(assignment());
  for (std::size_t index = 0; index < subchains; ++index) {
    controllers_.push_back(std::make_unique<TriggerThread>(*controls_, subchains_, SubchainId(index)));
  }
  // A subchain that is the only one shares with nobody.
  for (std::size_t core = 0; plan_ && subchains > 1 && core < cpus_.size(); ++core) {
    controllers_.push_back(std::make_unique<CoreThread>(*controls_, subchains_, static_cast<int>(core)));
  }
  controller_ids_.resize(controllers_.size());
  for (std::size_t index = 0; index < controllers_.size(); ++index) {
    threads_.push_back(os_.spawn(index < subchains ? "catan-trigger" : "catan-core", [this, index] {
      controller_ids_[index] = os_.current_thread();
      report_ready_and_wait();
      if (!abandoned_.load()) controllers_[index]->run();
    }));
  }
}

void Engine::spawn_nodes() {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    const graph::Node& node = app_.graph.nodes()[index];
    if (node.external) continue;
    const NodeId id(index);
    threads_.push_back(os_.spawn(node.name, [this, id] {
      wiring_.port(id)->add_thread(os_.current_thread());
      report_ready_and_wait();
      if (abandoned_.load()) return;
      app_.graph.node(id).unscheduled ? run_unscheduled(id) : run_node(id);
    }));
  }
}

void Engine::report_ready_and_wait() {
  ready_.fetch_add(1, std::memory_order_release);
  os_.wake(ready_);
  while (go_.load(std::memory_order_acquire) == 0) os_.wait(go_, 0, kNever);
}

void Engine::wait_until_ready(std::size_t threads) {
  for (;;) {
    const std::uint32_t ready = ready_.load(std::memory_order_acquire);
    if (ready >= threads) return;
    os_.wait(ready_, ready, kNever);
  }
}

void Engine::run_node(NodeId node) {
  NodePort& port = *wiring_.port(node);
  const NodeBody& body = wiring_.body(node);
  Run run;
  while (port.wait_for_trigger()) {
    port.begin(run);
    body(run);
    port.end(run);
  }
}

void Engine::run_unscheduled(NodeId node) {
  NodePort& port = *wiring_.port(node);
  const NodeBody& body = wiring_.body(node);
  const Nanos period = app_.graph.node(node).period.value_or(std::chrono::milliseconds{10});
  Run run;
  for (TimePoint next = os_.now() + period; !port.stopping(); next = std::max(next + period, os_.now())) {
    os_.sleep_until(next);
    if (port.stopping()) return;
    port.begin(run);
    body(run);
    port.end(run);
  }
}

// Nodes that share a core wait in the background for their dispatcher.
Status Engine::place_nodes() {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    const graph::Node& node = app_.graph.nodes()[index];
    if (node.external) continue;
    os::CpuSet cpus = cpus_;
    os::Level level = level_of_unscheduled();
    if (node.subchain) {
      const SubchainPlace& place = places_[node.subchain->index()];
      cpus = place.cpus;
      level = place.core >= 0 ? os::Level::kBackground : place.level;
    }
    for (const os::ThreadId thread : wiring_.port(NodeId(index))->threads()) {
      if (Status placed = enforcer_->apply(thread, level, cpus); !placed) return placed;
    }
  }
  return Done{};
}

Status Engine::place_controllers() {
  const os::Level level = level_of_controllers();
  for (std::size_t index = 0; index < controller_ids_.size(); ++index) {
    if (Status placed = enforcer_->apply(controller_ids_[index], level, cpus_of_controller(index)); !placed) {
      return placed;
    }
  }
  return Done{};
}

// A core's thread runs on its core; where that is gone, the system says where. Who paces may run anywhere.
os::CpuSet Engine::cpus_of_controller(std::size_t index) const {
  const std::size_t subchains = app_.graph.subchains().size();
  return index < subchains ? there_ : os::common(there_, os::CpuSet{cpus_.cpus()[index - subchains]});
}

void Engine::follow_cpus(TimePoint now) {
  if (options_.policy.kind != Policy::Kind::kCatan || now < next_look_) return;
  next_look_ = now + kLookAtCpus;
  const Result<os::CpuSet> online = os_.online_cpus();
  if (!online) return;
  const os::CpuSet there = os::common(cpus_, *online);
  if (there == there_ || there.empty()) return;
  there_ = there;
  housekeeper_->notice("cpus", fmt::format("of CPUs {}, {} are online: planning for these", os::to_string(cpus_),
                                           os::to_string(there_)));
  make_plan_anew(now, "cpus", true);
  place_anew();
}

// Threads that belong to no subchain: the system has moved those whose CPU went, and does not move them back.
void Engine::place_anew() {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    if (!app_.graph.nodes()[index].unscheduled) continue;
    wiring_.port(NodeId(index))->for_each_thread([&](os::ThreadId thread) { enforcer_->move_now(thread, there_); });
  }
  for (std::size_t index = 0; index < controller_ids_.size(); ++index) {
    const os::CpuSet cpus = cpus_of_controller(index);
    if (!cpus.empty()) enforcer_->move_now(controller_ids_[index], cpus);
  }
}

void Engine::replan(TimePoint now) {
  follow_cpus(now);
  if (!replan_clock_ || !replan_clock_->due(now, housekeeper_->all_measured())) return;
  const bool first = replan_clock_->first();
  if (!first && !options_.replan) return;
  make_plan_anew(now, first ? "measured" : "periodic", first);
}

// `at_any_rate`: also if it is no better than the one in force.
void Engine::make_plan_anew(TimePoint now, const std::string& reason, bool at_any_rate) {
  const bool all_measured = housekeeper_->all_measured();
  if (replan_clock_ && all_measured) replan_clock_->made(now);
  const Millis unmeasured = app_.scheduler.bootstrap_cost;
  const model::CostTable costs = housekeeper_->costs(unmeasured);
  Result<plan::Plan> plan = make_plan(costs, housekeeper_->typical_costs(unmeasured));
  if (!plan) {
    if (!replan_failed_) housekeeper_->notice("replan-failed", plan.error().message());
    replan_failed_ = true;
    return;
  }
  replan_failed_ = false;
  if (at_any_rate || worth_a_swap(*plan_, plan::recost(*plan_, app_, costs), *plan)) adopt(std::move(*plan), reason);
}

void Engine::adopt(plan::Plan plan, const std::string& reason) {
  plan_ = std::move(plan);
  publish(assignment());
  housekeeper_->plan_in_force(*plan_, source_rate(), reason);
}

void Engine::end_threads() {
  if (housekeeper_thread_) {
    housekeeper_->stop();
    housekeeper_thread_->join();
    housekeeper_thread_.reset();
  }
  // Everything is given back while the threads still live; what runs are under way end at the ordinary level.
  if (enforcer_) enforcer_->release_all();
  ready_cpus_.reset();
  go_.store(1, std::memory_order_release);
  os_.wake(go_);
  for (const auto& controller : controllers_) controller->stop();
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    if (NodePort* port = wiring_.port(NodeId(index))) port->stop();
  }
  for (const auto& thread : threads_) thread->join();
  threads_.clear();
}

Status Engine::stop() {
  if (!started_ || stopped_at_ != TimePoint{}) return stopped_;
  end_threads();
  stopped_at_ = os_.now();
  stopped_ = housekeeper_->finish(controllers_);
  return stopped_;
}

Status Engine::adopt_this_thread(std::string_view node) {
  const std::optional<NodeId> id = app_.graph.find_node(node);
  NodePort* port = id ? wiring_.port(*id) : nullptr;
  if (port == nullptr) {
    return Error::caller(fmt::format("app {} has no node '{}' of its own", app_.name, node),
                         "use a name from its nodes section that is not external");
  }
  if (!port->add_thread(os_.current_thread())) {
    return Error::caller(fmt::format("node {} has {} threads already", node, NodePort::kMaxThreads),
                         "use fewer threads");
  }
  if (!enforcer_) return Done{};  // placed with the others at the start
  const graph::Node& scheduled = app_.graph.node(*id);
  os::Level level = os::Level::kOrdinary;
  if (options_.policy.raises()) level = scheduled.unscheduled ? level_of_unscheduled() : os::Level::kBackground;
  if (Status placed = enforcer_->apply(os_.current_thread(), level, cpus_); !placed) return placed;
  // Whoever holds its subchain knows better.
  if (scheduled.subchain) wiring_.signal(*scheduled.subchain).thread_joined(os_);
  return Done{};
}

Snapshot Engine::snapshot() const {
  Snapshot snapshot;
  snapshot.policy = options_.policy.name;
  if (!housekeeper_) return snapshot;
  snapshot.real_time = enforcer_->real_time();
  std::optional<double> hand_set_hz;
  if (!options_.policy.follows_plan()) hand_set_hz = source_rate().hertz();
  housekeeper_->fill(snapshot, hand_set_hz);
  return snapshot;
}

}  // namespace ctn::runtime
