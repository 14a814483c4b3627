#include "bench/hand_over.h"

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "bench/gaps.h"
#include "config/app_file.h"
#include "runtime/controller_thread.h"
#include "runtime/node_port.h"

namespace ctn::tool {
namespace {

constexpr Nanos kSlice = std::chrono::milliseconds{1};
constexpr Nanos kRound = std::chrono::milliseconds{250};
constexpr Nanos kSettle = std::chrono::milliseconds{20};
// More than any kernel keeps for ordinary threads, so that it takes nothing by force.
constexpr double kSlack = 0.08;
// Of a frame's two slices: whole, like the dispatcher's, at the end of every second frame.
constexpr Nanos kBareSlack = std::chrono::microseconds{348};
constexpr int kFramesToSlack = 2;

constexpr const char* kApp = R"(
catan: 1
app: bench
nodes: { one: {}, other: {} }
edges: []
objective: [ { period: one, weight: 1 }, { period: other, weight: 1 } ]
)";

// Two threads that keep one core busy until a time, and note their gaps.
class BusyPair {
 public:
  BusyPair(os::Os& os, int cpu, TimePoint until, std::function<void(std::size_t)> before_spinning)
      : os_(os), cpu_(cpu), until_(until), before_(std::move(before_spinning)) {
    for (std::size_t index = 0; index < 2; ++index) {
      threads_[index] = os.spawn("bench-busy", [this, index] { run(index); });
    }
    for (std::uint32_t seen = 0; seen < 2; seen = ready_.load()) os.wait(ready_, seen, kNever);
  }
  ~BusyPair() { join(); }
  BusyPair(const BusyPair&) = delete;
  BusyPair& operator=(const BusyPair&) = delete;

  os::ThreadId number(std::size_t index) const { return numbers_[index]; }
  void go() {
    go_.store(1);
    os_.wake(go_);
  }
  void join() {
    go();
    for (auto& thread : threads_) thread.reset();
  }
  // After join().
  const std::vector<Gap>& gaps(std::size_t index) const { return logs_[index].gaps(); }

 private:
  void run(std::size_t index) {
    numbers_[index] = os_.current_thread();
    static_cast<void>(os_.set_affinity(numbers_[index], os::CpuSet{cpu_}));
    ready_.fetch_add(1);
    os_.wake(ready_);
    while (go_.load() == 0) os_.wait(go_, 0, kNever);
    if (before_) before_(index);
    logs_[index].spin(os_, until_);
  }

  os::Os& os_;
  int cpu_;
  TimePoint until_;
  std::function<void(std::size_t)> before_;
  std::atomic<std::uint32_t> ready_{0};
  std::atomic<std::uint32_t> go_{0};
  os::ThreadId numbers_[2]{};
  GapLog logs_[2];
  std::unique_ptr<os::Thread> threads_[2];
};

struct Samples {
  std::vector<Nanos> hand_overs;
  std::vector<Nanos> costs;  // by round: CPU time of the thread that dispatches, by hand-over

  void add(const std::vector<TimePoint>& slice_ends, const BusyPair& pair, Nanos cpu) {
    if (slice_ends.empty()) return;
    const std::vector<Nanos> more = ctn::tool::hand_overs(slice_ends, pair.gaps(1));
    hand_overs.insert(hand_overs.end(), more.begin(), more.end());
    // Half of them are from the other to the one.
    costs.push_back(cpu / static_cast<std::int64_t>(2 * slice_ends.size()));
  }
};

// --- The least that can be ---

class BareDispatcher {
 public:
  BareDispatcher(os::Os& os, const BusyPair& pair) : os_(os), pair_(pair) { slice_ends_.reserve(GapLog::kMax); }

  void run(TimePoint until) {
    TimePoint at = os_.now();
    for (int frame = 1; at < until; ++frame) {
      os_.shift_level(pair_.number(1), os::Level::kBackground);
      os_.shift_level(pair_.number(0), os::Level::kActive);
      at = os_.now() + kSlice;
      slice_ends_.push_back(at);
      os_.sleep_until(at);
      os_.shift_level(pair_.number(0), os::Level::kBackground);
      os_.shift_level(pair_.number(1), os::Level::kActive);
      at = os_.now() + kSlice;
      os_.sleep_until(at);
      if (frame % kFramesToSlack == 0) leave_slack();
    }
    leave_slack();
  }
  const std::vector<TimePoint>& slice_ends() const { return slice_ends_; }

 private:
  void leave_slack() {
    for (const std::size_t index : {std::size_t{1}, std::size_t{0}})
      os_.shift_level(pair_.number(index), os::Level::kOrdinary);
    os_.sleep_until(os_.now() + kBareSlack);
  }

  os::Os& os_;
  const BusyPair& pair_;
  std::vector<TimePoint> slice_ends_;
};

Status measure_bare(const BenchContext& context, Samples& samples) {
  os::Os& os = context.os;
  const TimePoint until = os.now() + kRound;
  BusyPair pair(os, context.core, until + kSettle, {});
  BareDispatcher dispatcher(os, pair);
  Status placed = Done{};
  Nanos cpu{0};
  const auto thread = os.spawn("bench-bare", [&] {
    placed = place_this_thread(os, os::Level::kDispatcher, context.core);
    if (!placed) return;
    pair.go();
    cpu = os.thread_cpu_time();
    dispatcher.run(until);
    cpu = os.thread_cpu_time() - cpu;
  });
  thread->join();
  pair.join();
  if (placed) samples.add(dispatcher.slice_ends(), pair, cpu);
  return placed;
}

// --- The runtime ---

class SliceEnds : public runtime::ReportSink {
 public:
  void triggered(const record::Trigger& /*trigger*/) override {}
  void slot_over(const record::SlotUse& slot) override {
    if (slot.subchain == SubchainId(std::size_t{0})) ends.push_back(slot.planned + kSlice);
  }
  void stole(const record::Steal& /*steal*/) override {}
  void hang_changed(SubchainId /*subchain*/, bool /*began*/, TimePoint /*at*/) override {}
  void over_budget(const record::Overrun& /*overrun*/) override {}
  void woke_late(int, TimePoint, TimePoint) override {}

  std::vector<TimePoint> ends;
};

// Two subchains of one node each, on one core; no run ends before the measurement does.
runtime::Assignment two_slots(const BenchContext& context) {
  runtime::Assignment assignment;
  dispatch::SharedCoreSchedule& schedule = assignment.cores.emplace_back();
  schedule.slack = kSlack;
  for (std::size_t index = 0; index < 2; ++index) {
    policy::SubchainPlace& place = assignment.places.emplace_back();
    place.core = 0;
    place.cpus = os::CpuSet{context.core};
    dispatch::SharedCoreSlot& slot = schedule.slots.emplace_back();
    slot.subchain = SubchainId(index);
    slot.slice = kSlice;
    slot.every = 1;
    slot.rank = static_cast<int>(index);
    slot.may_steal = false;
  }
  return assignment;
}

Status measure_runtime(const BenchContext& context, const graph::App& app, Samples& samples) {
  os::Os& os = context.os;
  const TimePoint until = os.now() + kRound;
  runtime::Enforcer enforcer(os, true, nullptr, {});
  runtime::LocalRegion memory(app.graph, 1);
  const runtime::Region& region = memory.region();
  const runtime::Links links = runtime::links_of(os, app.graph, region);
  const std::vector<runtime::SubchainLinks> subchains = runtime::subchain_links(app.graph, links, region);
  runtime::Controls controls(os, enforcer, region, app.graph, 1);
  for (runtime::Handover& handover : controls.handovers) handover.put({});
  controls.board.publish(two_slots(context));
  runtime::ControllerThread core(controls, subchains, driver::number_of_core(0, subchains.size()));

  std::vector<std::unique_ptr<runtime::NodePort>> ports;
  for (std::size_t index = 0; index < 2; ++index) {
    ports.push_back(std::make_unique<runtime::NodePort>(os, app.graph, NodeId(index), region));
  }
  ctn::Run runs[2];
  BusyPair pair(os, context.core, until, [&](std::size_t index) {
    if (ports[index]->wait_for_trigger()) ports[index]->begin(runs[index]);
  });
  for (std::size_t index = 0; index < 2; ++index) links[index]->add_thread(pair.number(index));

  Status placed = Done{};
  Nanos cpu{0};
  const auto thread = os.spawn("bench-core", [&] {
    placed = place_this_thread(os, os::Level::kDispatcher, context.core);
    pair.go();
    cpu = os.thread_cpu_time();
    if (placed) core.run();
    cpu = os.thread_cpu_time() - cpu;
  });
  os.sleep_until(until);
  core.stop();
  thread->join();
  for (const auto& port : ports) port->stop();
  pair.join();
  if (!placed) return placed;
  SliceEnds sink;
  core.drain(sink);
  samples.add(sink.ends, pair, cpu);
  return Done{};
}

}  // namespace

Result<std::vector<Figure>> measure_hand_over(const BenchContext& context) {
  const Result<graph::App> app = config::parse_app(kApp, "bench");
  if (!app) return app.error();
  Samples measured;
  Samples bare;
  const TimePoint until = context.os.now() + part_of(context, 0.3);
  do {
    if (Status done = measure_bare(context, bare); !done) return done.error();
    if (Status done = measure_runtime(context, *app, measured); !done) return done.error();
  } while (context.os.now() < until);
  const std::string bare_is = "a real-time thread that wakes by an absolute timer and changes two levels";
  const std::string where = "busy core";
  return std::vector<Figure>{{"hand-over",
                              where,
                              kMicros,
                              summarize_micros(measured.hand_overs),
                              bare_is,
                              summarize_micros(bare.hand_overs),
                              {.ratio = 1.3, .p50 = {}, .p99 = 120.0}},
                             {"CPU of a hand-over",
                              where,
                              kMicros,
                              summarize_micros(measured.costs),
                              bare_is,
                              summarize_micros(bare.costs),
                              {}}};
}

}  // namespace ctn::tool
