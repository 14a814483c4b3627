#include "sim/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "driver/planning_loop.h"
#include "policy/planned.h"
#include "sim/controllers.h"
#include "sim/cpus.h"

namespace ctn::sim {
namespace {

os::CpuSet first_cpus(int count) {
  std::vector<int> numbers;
  for (int cpu = 0; cpu < count; ++cpu) numbers.push_back(cpu);
  return os::CpuSet(std::move(numbers));
}

std::vector<double> speeds(const graph::App& app, const Machine& machine) {
  std::vector<double> speeds;
  for (int core = 0; core < machine.cores; ++core) {
    speeds.push_back(app.core_kinds.empty() ? 1.0 : app.core_kinds[app.kind_of(core)].speed);
  }
  if (machine.housekeeping_elsewhere) speeds.push_back(1.0);
  return speeds;
}

static_assert(kMaxCores < kMaxCpus);

// All that is decided before anything runs.
struct Setting {
  graph::App app;
  os::CpuSet cpus;
  policy::CpuKinds kinds;
};

driver::PlanningOptions planning_options(const Setting& setting, const Options& options) {
  return {.policy = options.policy,
          .cpus = setting.cpus,
          .slack = options.slack.value_or(setting.app.scheduler.slack.value_or(graph::kDefaultSlack)),
          .stealing = options.stealing,
          .replan = options.replan,
          .frames = options.frames,
          .known_costs = options.costs,
          .timer = [cpu = options.machine.costs.planning](const std::function<void()>& plan) {
            plan();
            return driver::PlanningTime{.cpu = cpu};
          }};
}

Clocks clocks_of(const graph::Graph& graph, const Options& options) {
  Clocks clocks = draw_clocks(graph, options.clocks);
  const Phases& phases = options.phases;
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    if (!phases.nodes.empty()) clocks.timers[index].tick = TimePoint{} + phases.nodes[index];
    if (phases.clocks.empty() || phases.clocks[index].period <= Nanos{0}) continue;
    (graph.nodes()[index].external ? clocks.external : clocks.timers)[index] = phases.clocks[index];
  }
  return clocks;
}

}  // namespace

// Threads: of nodes, of controllers, of housekeeping, of background loads.
class Simulation::Impl : public Cpus::Client, private Nodes::Client, private driver::PlanningHost {
 public:
  Impl(Setting setting, std::unique_ptr<RunCosts> costs, Options options)
      : setting_(std::move(setting)),
        options_(std::move(options)),
        costs_(std::move(costs)),
        app_(setting_.app),
        first_controller_(static_cast<Cpus::Thread>(Nodes::threads_needed(app_, options_.machine.cores))),
        housekeeping_(first_controller_ + static_cast<Cpus::Thread>(max_controllers())),
        cpus_(options_.machine, speeds(app_, options_.machine), housekeeping_ + 1 + options_.machine.background.size(),
              *this),
        nodes_(app_, options_.machine, setting_.kinds, *costs_, cpus_, 0, *this),
        warm_from_(TimePoint{} + app_.scheduler.bootstrap + policy::kSettle),
        loop_(app_, planning_options(setting_, options_)),
        measurements_(app_, warm_from_),
        notices_({}, options_.recording.has_value()),
        event_log_(app_, loop_, measurements_, notices_),
        controllers_(app_, options_.machine, core_controllers(), nodes_, cpus_, first_controller_, event_log_),
        clocks_(clocks_of(app_.graph, options_)) {}

  Status prepare() {
    std::vector<Ticks> clocks = clocks_.external;
    for (std::size_t index = 0; index < clocks.size(); ++index) {
      if (clocks_.timers[index].period > Nanos{0}) clocks[index] = clocks_.timers[index];
      if (clocks[index].period > Nanos{0}) loop_.clock_known(NodeId(index), clocks[index]);
    }
    controllers_.know_clocks(clocks);
    const model::CostTable unmeasured(app_.graph, app_.scheduler.bootstrap_cost);
    if (!options_.plans.empty()) {
      loop_.begin_with(follow_next_plan(unmeasured));
    } else {
      if (Status decided = loop_.decide_first(); !decided) return decided;
      if (options_.reserve) {
        const model::CostTable& known = options_.costs ? *options_.costs : unmeasured;
        Result<std::vector<Reservation>> reserved = loop_.in_situation(known, options_.reserve);
        if (!reserved) return reserved.error();
        nodes_.reserve(std::move(*reserved));
      }
    }
    if (Status opened = open_record(); !opened) return opened;
    for (std::size_t index = 0; index < clocks.size(); ++index) {
      if (clocks[index].period > Nanos{0}) event_log_.clock_read({TimePoint{}, NodeId(index), clocks[index]});
    }
    measurements_.cpus_in_use(setting_.cpus);
    loop_.begin(TimePoint{}, *this);
    return Done{};
  }

  Status status() const {
    if (mistakes_.empty()) return Done{};
    return Error(ErrorKind::kCaller, mistakes_);
  }

  Status finish() {
    measure_totals();
    return event_log_.close(cpus_.now(), host_facts());
  }

  void run_for(Nanos duration) {
    const TimePoint end = cpus_.now() + duration;
    if (!started_) start();
    if (cpus_.now() < warm_from_ && end >= warm_from_) {
      cpus_.run_until(warm_from_);
      cpus_.forget_use();
    }
    cpus_.run_until(end);
  }

  Outcome outcome() {
    const TimePoint now = cpus_.now();
    Outcome outcome = outcome_of(app_, measurements_, now);
    outcome.scheduler = options_.policy->name();
    const auto measured = static_cast<double>(std::max(now - warm_from_, Nanos{0}).count());
    for (int core = 0; core < options_.machine.cores; ++core) {
      const Cpus::Used used = cpus_.use_of(core);
      CoreOutcome& shown = outcome.cores.emplace_back();
      if (measured <= 0.0) continue;
      shown.real_time = static_cast<double>(used.real_time.count()) / measured;
      shown.ordinary = static_cast<double>(used.ordinary.count()) / measured;
    }
    outcome.source_hz = loop_.hand_set_hz().value_or(outcome.source_hz);
    outcome.dropped = nodes_.dropped();
    outcome.throttled = cpus_.throttled();
    outcome.plans_made = loop_.budget().plans();
    outcome.notices = notices_.newest();
    return outcome;
  }

  Snapshot snapshot() {
    measure_totals();
    Snapshot snapshot;
    snapshot.policy = options_.policy->name();
    snapshot.real_time = real_time();
    measurements_.fill(snapshot, cpus_.now(), app_, loop_.hand_set_hz());
    snapshot.notices = notices_.newest();
    return snapshot;
  }

  Nodes& nodes() { return nodes_; }
  const Cpus& cpus() const { return cpus_; }
  const std::optional<plan::Plan>& plan() const { return loop_.decision().plan; }
  TimePoint warm_from() const { return warm_from_; }

  // --- What threads do ---

  Nanos begin(Cpus::Thread thread, int cpu) override {
    if (thread < first_controller_) return nodes_.begin(thread, cpu);
    if (thread < housekeeping_) return controllers_.begin(thread, cpu);
    if (thread == housekeeping_) return do_housekeeping();
    return options_.machine.background[thread - housekeeping_ - 1].busy;
  }

  bool done(Cpus::Thread thread, int cpu) override {
    if (thread < first_controller_) return nodes_.done(thread, cpu);
    if (thread < housekeeping_) return controllers_.done(thread);
    if (thread == housekeeping_) {
      end_housekeeping();
    } else {
      BackgroundState& load = background_[thread - housekeeping_ - 1];
      load.next = std::max(load.next + load.period, cpus_.now());
      if (load.next <= cpus_.now()) return true;
      cpus_.wake_at(thread, load.next);
    }
    return false;
  }

 private:
  struct BackgroundState {
    Nanos period{0};
    TimePoint next{};
  };

  // A subchain that is the only one shares its core with no other.
  int core_controllers() const {
    return options_.policy->follows_plan() && app_.graph.subchains().size() > 1 ? options_.machine.cores : 0;
  }
  std::size_t max_controllers() const {
    return app_.graph.subchains().size() + static_cast<std::size_t>(core_controllers());
  }

  bool real_time() const { return options_.machine.real_time && options_.policy->raises(); }

  void start() {
    started_ = true;
    nodes_.start(setting_.cpus, loop_.levels().scheduled, loop_.levels().unscheduled, clocks_.timers, clocks_.external);
    controllers_.start(loop_.decision().assignment, setting_.cpus, loop_.levels().dispatcher,
                       options_.phases.subchains);
    const Machine& machine = options_.machine;
    cpus_.set_cpus(housekeeping_,
                   machine.housekeeping_elsewhere ? CpuMask::only(machine.cores) : CpuMask(setting_.cpus));
    if (loop_.adapts()) cpus_.wake_at(housekeeping_, TimePoint{} + driver::kPlanningStep);
    for (const BackgroundLoad& load : machine.background) {
      const Cpus::Thread thread = housekeeping_ + 1 + static_cast<Cpus::Thread>(background_.size());
      background_.push_back({std::max(load.period, Nanos{1}), TimePoint{}});
      cpus_.set_cpus(thread, CpuMask::only(load.core));
      cpus_.wake(thread, -1);
    }
  }

  // --- Events of nodes ---

  void run_ended(const record::Run& run) override { event_log_.ran(run); }

  void mistaken(Problem problem) override {
    mistakes_.push_back(std::move(problem));
    cpus_.stop();
  }

  void wake(std::size_t controller, int from_cpu) override { controllers_.wake(controller, from_cpu); }

  // --- Re-planning: the loop does its steps in the housekeeping thread ---

  Nanos do_housekeeping() {
    const Nanos collect = options_.machine.costs.collect;
    if (options_.plans.empty()) {
      next_ = loop_.plan(cpus_.now(), *this);
      return next_ ? collect + options_.machine.costs.planning : collect;
    }
    if (plans_followed_ < options_.plans.size() && TimePoint{} + options_.plans[plans_followed_].at <= cpus_.now()) {
      next_ = {.next = follow_next_plan(model::CostTable(app_.graph, Millis{0}))};
    }
    return collect;
  }

  void end_housekeeping() {
    if (std::optional<driver::Planned> next = std::exchange(next_, std::nullopt)) loop_.adopt(std::move(*next), *this);
    cpus_.wake_at(housekeeping_, cpus_.now() + driver::kPlanningStep);
  }

  Result<os::CpuSet> usable_cpus() override { return setting_.cpus; }
  os::PowerState power_state() override { return {}; }
  driver::ControllerWork controller_work() override { return controllers_.work(); }
  void cpus_changed(const os::CpuSet& /*cpus*/) override {}
  void notice(const std::string& kind, const std::string& detail) override {
    event_log_.notice({cpus_.now(), kind, detail});
  }
  void raise(const driver::Levels& levels) override {
    controllers_.set_level(levels.dispatcher);
    nodes_.set_level_of_unscheduled(levels.unscheduled);
  }
  void in_force(const policy::Decision& decision, policy::PlanReason reason) override {
    if (started_) controllers_.publish(decision.assignment);
    event_log_.in_force(cpus_.now(), decision, reason);
  }

  void measure_totals() {
    const std::uint64_t plans = loop_.budget().plans();
    measurements_.planned(plans, options_.machine.costs.planning * static_cast<Nanos::rep>(plans));
    measurements_.starved(cpus_.throttled(), Nanos{0});
  }

  os::HostFacts host_facts() const {
    return {.utc = {},
            .kernel = "none: simulated",
            .cpu_model = "simulated",
            .governor = {},
            .clock_source = "virtual time",
            .cpu_count = options_.machine.cores};
  }

  Status open_record() {
    if (!options_.recording) return Done{};
    record::Header header = loop_.record_header();
    header.host = host_facts();
    header.real_time = real_time();
    header.warm_up = warm_from_ - TimePoint{};
    header.note = options_.recording->note;
    auto writer = record::Writer::create(options_.recording->path, app_, header);
    if (!writer) return writer.error();
    event_log_.record_to(std::move(*writer));
    return Done{};
  }

  // Of the plans that are given.
  policy::Decision follow_next_plan(const model::CostTable& costs) {
    const plan::Plan& next = options_.plans[plans_followed_++].plan;
    return loop_.in_situation(
        costs, [&](const policy::Situation& now) { return policy::PlannedPolicy::following(next, now); });
  }

  Setting setting_;
  Options options_;
  std::unique_ptr<RunCosts> costs_;
  const graph::App& app_;
  Cpus::Thread first_controller_;
  Cpus::Thread housekeeping_;
  Cpus cpus_;
  Nodes nodes_;
  TimePoint warm_from_;
  driver::PlanningLoop loop_;
  Measurements measurements_;
  driver::Notices notices_;
  EventLog event_log_;
  Controllers controllers_;
  Clocks clocks_;
  std::vector<BackgroundState> background_;
  bool started_ = false;
  std::vector<Problem> mistakes_;  // of functions

  std::size_t plans_followed_ = 0;       // of those that are given
  std::optional<driver::Planned> next_;  // in force once the housekeeping thread's step has ended
};

Result<std::unique_ptr<Simulation>> Simulation::create(const graph::App& app, std::unique_ptr<RunCosts> costs,
                                                       Options options) {
  const Machine& machine = options.machine;
  if (machine.cores < 1 || machine.cores > kMaxCores) {
    return Error::caller(fmt::format("{} cores cannot be simulated", machine.cores),
                         fmt::format("choose from 1 to {}", kMaxCores));
  }
  const os::CpuSet cpus = first_cpus(machine.cores);
  if (Status fits = policy::CpuKinds::fits(app, cpus); !fits) return fits.error();
  Setting setting{policy::as_run_by(*options.policy, app), cpus, policy::CpuKinds(app, cpus)};
  setting.app.scheduler.frames = options.frames.value_or(app.scheduler.frames);
  auto impl = std::make_unique<Impl>(std::move(setting), std::move(costs), std::move(options));
  if (Status prepared = impl->prepare(); !prepared) return prepared.error();
  return std::unique_ptr<Simulation>(new Simulation(std::move(impl)));
}

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulation::~Simulation() = default;

void Simulation::set_body(NodeId node, Body body) { impl_->nodes().set_body(node, std::move(body)); }
void Simulation::set_effect(NodeId node, Body effect) { impl_->nodes().set_effect(node, std::move(effect)); }
void Simulation::use_channel(NodeId consumer, std::size_t input, ChannelBase& channel) {
  impl_->nodes().use_channel(consumer, input, channel);
}
TimePoint Simulation::now() const { return impl_->cpus().now(); }
TimePoint Simulation::warm_from() const { return impl_->warm_from(); }
void Simulation::run_for(Nanos duration) { impl_->run_for(duration); }
Status Simulation::status() const { return impl_->status(); }
Outcome Simulation::outcome() { return impl_->outcome(); }
Snapshot Simulation::snapshot() { return impl_->snapshot(); }
const std::optional<plan::Plan>& Simulation::plan() const { return impl_->plan(); }
std::uint64_t Simulation::events() const { return impl_->cpus().events(); }
Status Simulation::finish() { return impl_->finish(); }
Nodes& Simulation::nodes() { return impl_->nodes(); }

Result<Outcome> simulate(const graph::App& app, std::unique_ptr<RunCosts> costs, Options options, Nanos measured,
                         const std::function<void(double)>& on_progress) {
  auto simulation = Simulation::create(app, std::move(costs), std::move(options));
  if (!simulation) return simulation.error();
  constexpr Nanos kBetweenProgress = std::chrono::seconds{10};  // of virtual time
  const Nanos whole = (*simulation)->warm_from() - TimePoint{} + measured;
  for (Nanos done{0}; on_progress && done + kBetweenProgress < whole; done += kBetweenProgress) {
    (*simulation)->run_for(kBetweenProgress);
    on_progress(Millis{done + kBetweenProgress} / Millis{whole});
  }
  (*simulation)->run_for(whole - ((*simulation)->now() - TimePoint{}));
  if (Status ran = (*simulation)->status(); !ran) return ran.error();
  if (Status finished = (*simulation)->finish(); !finished) return finished.error();
  return (*simulation)->outcome();
}

}  // namespace ctn::sim
