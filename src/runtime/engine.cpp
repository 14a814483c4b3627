#include "runtime/engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plan/predict.h"
#include "planner/planner.h"

namespace ctn::runtime {
namespace {

// Between the end of the bootstrap and the first sample that counts: the first measured plan comes into force and what
// was under way under the old one ends.
constexpr Nanos kSettle = std::chrono::milliseconds{500};
// More than the kernel keeps for ordinary threads, so that it never has to take it by force.
constexpr double kSlackMargin = 0.01;

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

// What the planner can do and the runtime cannot yet.
Error cannot_share(const plan::Plan& plan) {
  return Error::caller(
      fmt::format(
          "the plan has subchains share a core ({} subchains on {} CPUs), which this version's runtime cannot enforce",
          plan.subchains.size(), plan.cores.size()),
      "give the session as many CPUs as the app has subchains, or put its nodes into fewer subchains");
}

// What runs cost is measured on whatever core they are on, and not yet told apart.
Error cores_must_be_alike() {
  return Error::caller("the app lists kinds of cores, which this version plans for but does not measure apart",
                       "remove cores from the app file, and give the session CPUs of one kind");
}

}  // namespace

Result<std::unique_ptr<Engine>> Engine::create(graph::App app, os::Os& os, EngineOptions options) {
  if (app.kinds() > 1) return cores_must_be_alike();
  Result<os::CpuSet> cpus = choose_cpus(os, options.cpus);
  if (!cpus) return cpus.error();
  return std::unique_ptr<Engine>(new Engine(std::move(app), os, std::move(options), std::move(*cpus)));
}

Engine::Engine(graph::App app, os::Os& os, EngineOptions options, os::CpuSet cpus)
    : app_(std::move(app)), os_(os), options_(std::move(options)), cpus_(std::move(cpus)), wiring_(app_, os_) {}

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
      os_.spawn("catan-house", [this] { housekeeper_->run(triggers_, [this](TimePoint now) { replan(now); }); });
  return Done{};
}

Status Engine::prepare() {
  if (Status wired = wiring_.check(); !wired) return wired;
  const os::RealTimeFacts facts = os_.real_time_facts();
  const bool real_time = options_.policy.plans() && facts.permitted;
  slack_ = app_.scheduler.slack.value_or(std::max(graph::kDefaultSlack, facts.reserved + kSlackMargin));
  if (Status paced = make_first_pacings(); !paced) return paced;

  const TimePoint start = os_.now();
  const TimePoint warm_from = start + app_.scheduler.bootstrap + kSettle;
  enforcer_ = std::make_unique<Enforcer>(os_, real_time,
                                         [this](const std::string& why) { housekeeper_->notice("rates-only", why); });
  std::unique_ptr<record::Writer> writer;
  if (Status opened = open_record(start, warm_from, writer); !opened) return opened;
  housekeeper_ = std::make_unique<Housekeeper>(app_, os_, wiring_, warm_from, std::move(writer), options_.on_notice);
  if (options_.policy.plans() && !facts.permitted) housekeeper_->notice("rates-only", facts.why_not);
  if (real_time) keep_cpus_ready();
  if (plan_) {
    replan_clock_.emplace(start, app_.scheduler);
    housekeeper_->plan_in_force(*plan_, source_rate(), "bootstrap");
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

Status Engine::make_first_pacings() {
  pacings_.clear();
  if (!options_.policy.plans()) {
    const Result<std::vector<Rate>> rates = hand_set_rates(options_.policy, app_);
    if (!rates) return rates.error();
    for (const Rate rate : *rates) pacings_.push_back({to_nanos(rate.period()), 0, Nanos{0}});
    return Done{};
  }
  const model::CostTable unmeasured(app_.graph, app_.scheduler.bootstrap_cost);
  Result<plan::Plan> plan = make_plan(unmeasured, unmeasured);
  if (!plan) return plan.error();
  plan_ = std::move(*plan);
  pace();
  return Done{};
}

void Engine::pace() {
  pacings_.clear();
  for (std::size_t index = 0; index < plan_->subchains.size(); ++index) {
    pacings_.push_back(pacing_of(app_, *plan_, SubchainId(index)));
  }
}

Rate Engine::source_rate() const { return Rate::every(pacings_.front().period); }

Result<plan::Plan> Engine::make_plan(const model::CostTable& costs, const model::CostTable& typical) {
  const TimePoint begin = os_.now();
  Result<plan::Plan> plan = planner::make_plan(app_, costs, {.cores = static_cast<int>(cpus_.size()), .slack = slack_});
  if (!plan) return plan;
  for (const plan::CorePlan& core : plan->cores) {
    if (!core.slots.empty()) return cannot_share(*plan);
  }
  plan->solve_time = os_.now() - begin;
  plan->expected = plan::expect(*plan, app_, typical);
  return plan;
}

Status Engine::spawn_and_place() {
  spawn_nodes();
  const std::size_t node_threads = threads_.size();
  wait_until_ready(node_threads);
  if (Status placed = place_nodes(); !placed) return placed;

  const graph::Graph& graph = app_.graph;
  trigger_ids_.resize(graph.subchains().size());
  for (std::size_t index = 0; index < graph.subchains().size(); ++index) {
    const SubchainId id(index);
    triggers_.push_back(std::make_unique<TriggerThread>(os_, id, wiring_.ports_of(id), wiring_.signal(id), *enforcer_,
                                                        pacings_[index]));
    threads_.push_back(os_.spawn("catan-trigger", [this, index] {
      trigger_ids_[index] = os_.current_thread();
      report_ready_and_wait();
      if (!abandoned_.load()) triggers_[index]->run();
    }));
  }
  wait_until_ready(threads_.size());
  return place_triggers();
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

os::CpuSet Engine::cpus_of(const plan::SubchainPlan& subchain) const {
  std::vector<int> cpus;
  for (const int core : subchain.cores) cpus.push_back(cpus_.cpus()[static_cast<std::size_t>(core)]);
  return os::CpuSet(std::move(cpus));
}

Status Engine::place_nodes() {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    const graph::Node& node = app_.graph.nodes()[index];
    if (node.external) continue;
    os::CpuSet cpus = cpus_;
    os::Level level = os::Level::kOrdinary;
    if (plan_) {
      level = node.unscheduled ? os::Level::kUnscheduled : os::Level::kActive;
      if (node.subchain) cpus = cpus_of(plan_->subchains[node.subchain->index()]);
    }
    for (const os::ThreadId thread : wiring_.port(NodeId(index))->threads()) {
      if (Status placed = enforcer_->apply(thread, level, cpus); !placed) return placed;
    }
  }
  return Done{};
}

Status Engine::place_triggers() {
  const os::Level level = plan_ ? os::Level::kDispatcher : os::Level::kOrdinary;
  for (const os::ThreadId thread : trigger_ids_) {
    if (Status placed = enforcer_->apply(thread, level, cpus_); !placed) return placed;
  }
  return Done{};
}

void Engine::replan(TimePoint now) {
  if (!replan_clock_ || !replan_clock_->due(now, housekeeper_->all_measured())) return;
  const bool first = replan_clock_->first();
  replan_clock_->made(now);
  const Millis unmeasured = app_.scheduler.bootstrap_cost;
  Result<plan::Plan> plan = make_plan(housekeeper_->costs(unmeasured), housekeeper_->typical_costs(unmeasured));
  if (!plan) {
    if (!replan_failed_) housekeeper_->notice("replan-failed", plan.error().message());
    replan_failed_ = true;
    return;
  }
  replan_failed_ = false;
  if (first || worth_a_swap(*plan_, *plan)) adopt(std::move(*plan), first ? "measured" : "periodic");
}

void Engine::adopt(plan::Plan plan, const std::string& reason) {
  const bool moves = !std::equal(plan.subchains.begin(), plan.subchains.end(), plan_->subchains.begin(),
                                 [](const auto& after, const auto& before) { return after.cores == before.cores; });
  plan_ = std::move(plan);
  if (moves) {
    if (const Status placed = place_nodes(); !placed)
      housekeeper_->notice("placement-failed", placed.error().message());
  }
  pace();
  for (std::size_t index = 0; index < triggers_.size(); ++index) {
    triggers_[index]->change_pacing(pacings_[index]);
  }
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
  for (const auto& trigger : triggers_) trigger->stop();
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
  stopped_ = housekeeper_->finish(triggers_);
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
  os::CpuSet cpus = cpus_;
  os::Level level = os::Level::kOrdinary;
  if (options_.policy.plans()) level = app_.graph.node(*id).unscheduled ? os::Level::kUnscheduled : os::Level::kActive;
  return enforcer_->apply(os_.current_thread(), level, cpus);
}

Snapshot Engine::snapshot() const {
  Snapshot snapshot;
  snapshot.policy = options_.policy.name;
  if (!housekeeper_) return snapshot;
  snapshot.real_time = enforcer_->real_time();
  std::optional<double> hand_set_hz;
  if (!options_.policy.plans()) hand_set_hz = source_rate().hertz();
  housekeeper_->fill(snapshot, hand_set_hz);
  return snapshot;
}

}  // namespace ctn::runtime
