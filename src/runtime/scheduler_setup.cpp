// What a scheduler does once, before anything is paced.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/scheduler.h"

namespace ctn::runtime {
namespace {

// More than the kernel keeps for ordinary threads, so that it never has to take it by force.
constexpr double kSlackMargin = 0.01;

}  // namespace

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

Result<std::unique_ptr<Scheduler>> Scheduler::create(const graph::App& app, os::Os& os, SchedulerOptions options,
                                                     os::CpuSet cpus, const Region& region) {
  if (Status fits = policy::CpuKinds::fits(app, cpus); !fits) return fits.error();
  return std::unique_ptr<Scheduler>(new Scheduler(app, os, std::move(options), std::move(cpus), region));
}

Scheduler::Scheduler(const graph::App& app, os::Os& os, SchedulerOptions options, os::CpuSet cpus, const Region& region)
    : app_(app),
      os_(os),
      options_(std::move(options)),
      cpus_(std::move(cpus)),
      kinds_(app_, cpus_),
      there_(cpus_),
      region_(region),
      links_(links_of(os, app_.graph, region)),
      in_force_(app_.graph.subchains().size(), false),
      members_(app_.graph.nodes().size(), false),
      broken_(app_.graph.subchains().size(), false) {
  app_.scheduler.frames = options_.frames.value_or(app_.scheduler.frames);
}

Status Scheduler::prepare() {
  const os::RealTimeFacts facts = os_.real_time_facts();
  const bool real_time = options_.policy->raises() && facts.permitted;
  slack_ = app_.scheduler.slack.value_or(std::max(graph::kDefaultSlack, facts.reserved + kSlackMargin));
  if (Status assigned = decide_first(); !assigned) return assigned;

  const TimePoint start = os_.now();
  const TimePoint warm_from = start + app_.scheduler.bootstrap + policy::kSettle;
  std::unique_ptr<os::Guard> guard;
  if (options_.guard) {
    Result<std::unique_ptr<os::Guard>> started = os_.start_guard();
    if (!started) return started.error();
    guard = std::move(*started);
  }
  enforcer_ = std::make_unique<Enforcer>(os_, real_time, std::move(guard),
                                         [this](const std::string& why) { housekeeper_->notice("rates-only", why); });
  std::unique_ptr<record::Writer> writer;
  if (Status opened = open_record(start, warm_from, writer); !opened) return opened;
  housekeeper_ = std::make_unique<Housekeeper>(app_, os_, links_, dropped_, warm_from, std::move(writer),
                                               options_.on_notice, kinds_);
  if (options_.policy->raises() && !facts.permitted) housekeeper_->notice("rates-only", facts.why_not);
  if (real_time) keep_cpus_ready();
  const bool adapts = options_.policy->adapts();
  if (adapts) adaptation_.emplace(app_, os_, cpus_, kinds_, start);
  if (decision_.plan) {
    const policy::PlanReason reason = adapts ? policy::PlanReason::kBootstrap : policy::PlanReason::kStatic;
    housekeeper_->plan_in_force(*decision_.plan, source_rate(), to_string(reason));
  }
  return Done{};
}

void Scheduler::keep_cpus_ready() {
  Result<std::unique_ptr<os::ReadyCpus>> ready = os_.keep_cpus_ready();
  if (ready) {
    ready_cpus_ = std::move(*ready);
  } else {
    housekeeper_->notice("idle-cpus", ready.error().message());
  }
}

Status Scheduler::open_record(TimePoint start, TimePoint warm_from, std::unique_ptr<record::Writer>& writer) {
  if (options_.record.empty()) return Done{};
  record::Header header;
  header.scheduler = options_.policy->name();
  header.cpus = cpus_;
  header.host = os_.host_facts();
  header.real_time = enforcer_->real_time();
  if (decision_.plan) header.slack = slack_;
  header.started = start;
  header.warm_up = warm_from - start;
  header.stealing = options_.stealing;
  header.note = options_.note;
  Result<std::unique_ptr<record::Writer>> created = record::Writer::create(options_.record, app_, header);
  if (!created) return created.error();
  writer = std::move(*created);
  return Done{};
}

Status Scheduler::decide_first() {
  const model::CostTable unmeasured(app_.graph, app_.scheduler.bootstrap_cost);
  Result<policy::Decision> decision = decide(unmeasured);
  if (!decision) return decision.error();
  decision_ = std::move(*decision);
  if (decision_.plan) slack_ = decision_.plan->slack;
  places_ = decision_.assignment.places;
  return Done{};
}

void Scheduler::spawn_controllers() {
  const std::size_t subchains = app_.graph.subchains().size();
  subchains_ = subchain_links(app_.graph, links_, region_);
  controls_ = std::make_unique<Controls>(os_, *enforcer_, region_, subchains, cpus_.size());
  for (Handover& handover : controls_->handovers) handover.put({});
  publish(assignment());
  // A subchain that is the only one shares with nobody.
  const std::size_t cores = decision_.plan && subchains > 1 ? cpus_.size() : 0;
  for (std::size_t number = 0; number < subchains + cores; ++number) {
    controllers_.push_back(std::make_unique<Controller>(*controls_, subchains_, number));
  }
  controller_ids_.resize(controllers_.size());
  for (std::size_t index = 0; index < controllers_.size(); ++index) {
    threads_.push_back(os_.spawn(index < subchains ? "catan-trigger" : "catan-core", [this, index] {
      controller_ids_[index] = os_.current_thread();
      ready_.fetch_add(1, std::memory_order_release);
      os_.wake(ready_);
      while (go_.load(std::memory_order_acquire) == 0) os_.wait(go_, 0, kNever);
      if (!abandoned_.load()) controllers_[index]->run();
    }));
  }
}

Status Scheduler::place_controllers() {
  const os::Level level = decision_.dispatcher_level;
  for (std::size_t index = 0; index < controller_ids_.size(); ++index) {
    if (Status placed = enforcer_->apply(controller_ids_[index], level, cpus_of_controller(index)); !placed) {
      return placed;
    }
  }
  return Done{};
}

// A core's thread runs on its core; where that is gone, the system says where. Who paces may run anywhere.
os::CpuSet Scheduler::cpus_of_controller(std::size_t index) const {
  const std::size_t subchains = app_.graph.subchains().size();
  return index < subchains ? there_ : os::common(there_, os::CpuSet{cpus_.cpus()[index - subchains]});
}

}  // namespace ctn::runtime
