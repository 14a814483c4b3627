#include "runtime/scheduler.h"

#include <fmt/format.h>

#include <algorithm>

#include "flight/recording.h"

namespace ctn::runtime {
namespace {

// A little more than the kernel keeps for ordinary threads, so that the kernel never has to enforce it.
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
      region_(region),
      links_(links_of(os, app_.graph, region)),
      notice_thread_(os, options_.on_notice, !options_.record.empty() || options_.flight_bytes > 0),
      notices_(notice_thread_.notices()),
      registered_(app_, os, region, links_, notices_) {
  app_.scheduler.frames = options_.frames.value_or(app_.scheduler.frames);
}

Scheduler::~Scheduler() {
  if (!parts_) return;
  end_scheduling();
  static_cast<void>(finish());
}

driver::PlanningLoop Scheduler::planning_loop(double slack) const {
  return {app_,
          {.policy = options_.policy,
           .cpus = cpus_,
           .slack = slack,
           .stealing = options_.stealing,
           .replan = options_.replan,
           .frames = options_.frames,
           .timer = [&os = os_](const std::function<void()>& plan) {
             const TimePoint begin = os.now();
             const Nanos cpu = os.thread_cpu_time();
             plan();
             return driver::PlanningTime{.cpu = os.thread_cpu_time() - cpu, .elapsed = os.now() - begin};
           }}};
}

Status Scheduler::prepare() {
  const policy::Policy& policy = *options_.policy;
  const os::RealTimeFacts facts = os_.real_time_facts();
  const bool real_time = policy.raises() && facts.permitted;
  const double slack = app_.scheduler.slack.value_or(std::max(graph::kDefaultSlack, facts.reserved + kSlackMargin));
  driver::PlanningLoop loop = planning_loop(slack);
  if (Status decided = loop.decide_first(); !decided) return decided;

  const TimePoint start = os_.now();
  const TimePoint warm_from = start + app_.scheduler.bootstrap + policy::kSettle;
  std::unique_ptr<os::Guardian> guardian;
  if (options_.guardian) {
    Result<std::unique_ptr<os::Guardian>> started = os_.start_guardian();
    if (!started) return started.error();
    guardian = std::move(*started);
  }
  const record::Header known = header(start, warm_from, real_time, loop);
  Result<std::unique_ptr<record::Writer>> writer = open_record(known);
  if (!writer) return writer.error();
  std::unique_ptr<flight::Recorder> recorder = open_recorder(known);
  const std::optional<double> hand_set_hz = loop.hand_set_hz();
  RegisteredNodes::Placement placement{
      .cpus = cpus_, .scheduled = loop.levels().scheduled, .unscheduled = loop.levels().unscheduled};
  parts_ = std::make_unique<Parts>(warm_from, hand_set_hz, real_time, std::move(guardian), std::move(*writer),
                                   std::move(recorder), std::move(loop), *this);
  registered_.open(parts_->enforcer, std::move(placement));
  parts_->allowed.watch(os_.main_thread(os_.current_process()));
  if (policy.raises() && !facts.permitted) notices_.add({os_.now(), "rates-only", facts.why_not});
  if (!os_.ready_time()) {
    notices_.add(
        {os_.now(), "waits-unknown",
         "this system does not tell how long threads were ready to run without running, so what runs wait is not "
         "measured, and plans leave it out (Linux: a kernel with CONFIG_SCHED_INFO tells)"});
  }
  if (real_time) keep_cpus_ready();
  parts_->housekeeping.idle().begin(start);
  prepared_.store(true, std::memory_order_release);
  notice_thread_.start();
  return Done{};
}

Scheduler::Parts::Parts(TimePoint warm, std::optional<double> hertz, bool real_time,
                        std::unique_ptr<os::Guardian> guardian, std::unique_ptr<record::Writer> writer,
                        std::unique_ptr<flight::Recorder> flight, driver::PlanningLoop loop, Scheduler& of)
    : warm_from(warm),
      hand_set_hz(hertz),
      recorder(std::move(flight)),
      enforcer(of.os_, real_time, std::move(guardian), &of.notices_),
      allowed(of.os_),
      asked(of.app_, of.cpus_),
      measurements(of.app_, warm),
      controllers(of.app_, of.os_, enforcer, of.region_, of.links_, of.cpus_),
      housekeeping(of.os_, of.app_, of.os_, of.region_, enforcer, allowed, asked, controllers,
                   Reporting{.links = of.links_,
                             .controllers = controllers.all(),
                             .registered = of.registered_,
                             .channels = of.channels_},
                   measurements, of.notices_, std::move(writer), recorder.get(), std::move(loop)) {}

void Scheduler::keep_cpus_ready() {
  Result<std::unique_ptr<os::ReadyCpus>> ready = os_.keep_cpus_ready();
  if (ready) {
    parts_->ready_cpus = std::move(*ready);
  } else {
    notices_.add({os_.now(), "idle-cpus", ready.error().message()});
  }
}

record::Header Scheduler::header(TimePoint start, TimePoint warm_from, bool real_time,
                                 const driver::PlanningLoop& loop) const {
  record::Header header = loop.record_header();
  header.host = os_.host_facts();
  header.real_time = real_time;
  header.started = start;
  header.warm_up = warm_from - start;
  header.note = options_.note;
  return header;
}

// Null where none is written.
Result<std::unique_ptr<record::Writer>> Scheduler::open_record(const record::Header& header) const {
  if (options_.record.empty()) return std::unique_ptr<record::Writer>();
  return record::Writer::create(options_.record, app_, header);
}

// Null where the last seconds are not kept; that this system has no memory for it is no reason not to schedule.
std::unique_ptr<flight::Recorder> Scheduler::open_recorder(const record::Header& header) {
  if (options_.flight_bytes == 0) return nullptr;
  Result<std::unique_ptr<flight::Recorder>> recorder =
      flight::Recorder::create(app_, header, os_.current_process(), options_.flight_bytes);
  if (recorder) return std::move(*recorder);
  notices_.add({os_.now(), "flight-recorder", "the last seconds are not kept: " + recorder.error().message()});
  return nullptr;
}

Status Scheduler::start() {
  Housekeeping& housekeeping = parts_->housekeeping.idle();
  const policy::Decision& decision = housekeeping.decision();
  housekeeping.pace_registered();
  parts_->controllers.spawn(options_.policy->follows_plan());
  if (Status placed = parts_->controllers.place(decision.dispatcher_level); !placed) {
    end_scheduling();
    return placed;
  }
  parts_->controllers.go();
  parts_->housekeeping.start("catan-house", [this](Housekeeping& mine) {
    mine.run([this](TimePoint deadline) { return parts_->housekeeping.sleep_until(deadline); });
  });
  return Done{};
}

void Scheduler::end_scheduling() {
  if (!parts_) return;
  scheduling_ended_.store(true, std::memory_order_release);
  registered_.expect_all_to_leave();
  parts_->housekeeping.request_stop();
  parts_->housekeeping.join();
  // Scheduling is restored while the nodes' threads are still alive, so runs that are under way end at the ordinary
  // level. It is done before the controllers end, because they then end sooner, and once more after, because until then
  // they still set levels.
  parts_->enforcer.restore_all();
  parts_->ready_cpus.reset();
  parts_->controllers.stop();
  parts_->enforcer.restore_for_good();
}

Status Scheduler::finish() {
  Status finished = parts_->housekeeping.idle().finish();
  notice_thread_.stop();
  return finished;
}

Status Scheduler::join(NodeId node, os::ProcessId process, os::ThreadId thread) {
  Status joined = registered_.join(node, process, thread);
  if (joined) parts_->housekeeping.wake();
  return joined;
}

Status Scheduler::add_thread(NodeId node, os::ProcessId process, os::ThreadId thread) {
  if (scheduling_ended_.load(std::memory_order_acquire)) {
    return Error::caller("the app does not run any more", "name threads between start and stop");
  }
  return registered_.add_thread(node, process, thread);
}

void Scheduler::remove_thread(NodeId node, os::ThreadId thread) { registered_.remove_thread(node, thread); }

void Scheduler::leave(NodeId node, const std::string& why) {
  if (registered_.leave(node, why)) parts_->housekeeping.wake();
}

Status Scheduler::change(const Changes& changes) {
  if (!prepared_.load(std::memory_order_acquire) || scheduling_ended_.load(std::memory_order_acquire)) {
    return Error::caller("nothing can be changed: the app does not run", "change it between start and stop");
  }
  if (!options_.policy->adapts()) {
    return Error::caller(
        fmt::format("nothing can be changed: scheduler '{}' never plans again", options_.policy->name()),
        "choose one that does: catan");
  }
  Status asked = parts_->asked.ask(changes);
  if (asked) parts_->housekeeping.wake();
  return asked;
}

Result<os::Descriptor> Scheduler::flight() const {
  if (prepared_.load(std::memory_order_acquire) && parts_->recorder) return parts_->recorder->readable();
  return Error::caller("the last seconds are not kept", "let it run, with a flight recorder of some size");
}

Status Scheduler::save_flight(const std::string& path, const std::string& why) const {
  Result<os::Descriptor> memory = flight();
  if (!memory) return memory.error();
  const Result<flight::Recording> recording = flight::Recording::open(std::move(*memory));
  if (!recording) return recording.error();
  return recording->save(path, why, os_.host_facts());
}

Snapshot Scheduler::snapshot() const {
  Snapshot snapshot;
  snapshot.policy = options_.policy->name();
  if (!prepared_.load(std::memory_order_acquire)) return snapshot;
  snapshot.real_time = parts_->enforcer.real_time();
  snapshot.changes = parts_->asked.count();
  parts_->measurements.fill(snapshot, os_.now(), parts_->asked.now().app, parts_->hand_set_hz);
  snapshot.notices = notices_.newest();
  return snapshot;
}

}  // namespace ctn::runtime
