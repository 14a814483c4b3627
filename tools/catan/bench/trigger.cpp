#include "bench/trigger.h"

#include <memory>
#include <utility>

#include "bench/peer.h"
#include "bench/shared_app.h"
#include "runtime/controller_thread.h"
#include "runtime/node_port.h"

namespace ctn::tool {
namespace {

// The longest wait for the other process.
constexpr Nanos kTimeout = std::chrono::seconds{2};

Error peer_is_gone() {
  return Error::environment("the other process of the measurement does not answer",
                            "check what ends or stops processes");
}

TimePoint first_instruction(const Agreement& agreement) { return TimePoint{Nanos{agreement.first.load()}}; }

void note_first_instruction(os::Os& os, Agreement& agreement) {
  agreement.first.store(os.now().time_since_epoch().count());
}

// Waits until the other has changed the word. False: it did not in good time.
bool await_change(os::Os& os, const std::atomic<std::uint32_t>& word, std::uint32_t from) {
  return os.wait(word, from, os.now() + kTimeout) == os::WaitResult::kChanged;
}

void set(os::Os& os, std::atomic<std::uint32_t>& word, std::uint32_t value) {
  word.store(value);
  os.wake(word);
}

// --- From trigger to first instruction ---

// The other process: triggered as a node is, and woken barely, in turn.
void be_triggered(os::Os& os, const SharedApp& app, int cpu) {
  if (!place_this_thread(os, os::Level::kActive, cpu)) return;
  Agreement& agreement = app.agreement();
  runtime::NodePort port(os, app.graph(), app.node(), app.region());
  ctn::Run run;
  set(os, agreement.done, 1);
  for (std::uint32_t turn = 0; port.wait_for_trigger(); ++turn) {
    port.begin(run);
    note_first_instruction(os, agreement);
    port.end(run);
    if (!await_change(os, agreement.go, turn)) return;
    note_first_instruction(os, agreement);
    set(os, agreement.done, turn + 2);
  }
}

// Triggers as a controller does, in a rhythm of its own.
class Triggering {
 public:
  Triggering(runtime::ControllerThread& controller, const BenchContext& context, Agreement& agreement)
      : controller_(controller), actuator_(controller), os_(context.os), cpu_(context.core), agreement_(agreement) {}

  void run(TimePoint until) {
    if (done = place_this_thread(os_, os::Level::kDispatcher, cpu_); !done) return;
    actuator_.await_completion(kSubchain, true, actuator_.completed(kSubchain));
    for (std::uint32_t turn = 0; done && os_.now() < until; ++turn) {
      // Long enough for all to be asleep, and of no fixed rhythm.
      pause(turn);
      if (!trigger_once(turn + 1)) done = peer_is_gone();
      pause(turn + 3);
      if (done && !wake_once(turn)) done = peer_is_gone();
    }
  }

  Status done = Done{};
  std::vector<Nanos> measured;
  std::vector<Nanos> bare;

 private:
  static constexpr SubchainId kSubchain{std::size_t{0}};

  void pause(std::uint32_t turn) { os_.sleep_until(os_.now() + std::chrono::microseconds{400 + 37 * (turn % 16)}); }

  bool trigger_once(std::uint64_t number) {
    const std::uint32_t seen = controller_.wake_count();
    const TimePoint sent = os_.now();
    actuator_.trigger(kSubchain, number, sent);
    controller_.sleep(seen, sent + kTimeout);
    if (actuator_.completed(kSubchain) < number) return false;
    measured.push_back(first_instruction(agreement_) - sent);
    return true;
  }

  bool wake_once(std::uint32_t turn) {
    const std::uint32_t seen = agreement_.done.load();
    const TimePoint sent = os_.now();
    set(os_, agreement_.go, turn + 1);
    if (!await_change(os_, agreement_.done, seen)) return false;
    bare.push_back(first_instruction(agreement_) - sent);
    return true;
  }

  runtime::ControllerThread& controller_;
  driver::Actuator& actuator_;  // the same
  os::Os& os_;
  int cpu_;
  Agreement& agreement_;
};

Result<Figure> trigger_figure(const BenchContext& context, int cpu, Nanos duration, std::string where) {
  os::Os& os = context.os;
  const Result<std::unique_ptr<SharedApp>> app = SharedApp::make();
  if (!app) return app.error();
  const SharedApp& shared = **app;
  const Peer peer(os, [&] { be_triggered(os, shared, cpu); });
  if (!await_change(os, shared.agreement().done, 0)) return peer_is_gone();

  runtime::Enforcer enforcer(os, true, nullptr, {});
  const runtime::Links links = runtime::links_of(os, shared.graph(), shared.region());
  const auto subchains = runtime::subchain_links(shared.graph(), links, shared.region());
  runtime::Controls controls(os, enforcer, shared.region(), shared.graph(), 0);
  runtime::ControllerThread controller(controls, subchains, 0);
  Triggering triggering(controller, context, shared.agreement());
  os.spawn("bench-trigger", [&] { triggering.run(os.now() + duration); })->join();
  if (!triggering.done) return triggering.done.error();
  return Figure{"trigger to first instruction",
                std::move(where),
                kMicros,
                summarize_micros(triggering.measured),
                "a futex wake between the same threads",
                summarize_micros(triggering.bare),
                {.ratio = 1.3, .p50 = {}, .p99 = {}}};
}

// --- What a report costs ---

constexpr int kBatch = 100;

struct BatchCost {
  Nanos reporting{0};
  Nanos bare{0};
};

BatchCost report_batch(os::Os& os, runtime::NodePort& port, ctn::Run& run, std::atomic<std::uint32_t>& trigger_word) {
  const TimePoint begin = os.now();
  for (int count = 0; count < kBatch; ++count) {
    // As its trigger would; the port takes it without a call to the kernel.
    trigger_word.store(trigger_word.load(std::memory_order_relaxed) + 1, std::memory_order_release);
    static_cast<void>(port.wait_for_trigger());
    port.begin(run);
    port.end(run);
  }
  const TimePoint middle = os.now();
  Nanos sum{0};
  for (int count = 0; count < kBatch; ++count) {
    sum += os.thread_cpu_time() + os.now().time_since_epoch();
    sum -= os.thread_cpu_time() + os.now().time_since_epoch();
  }
  const TimePoint end = os.now();
  static_cast<void>(sum);
  return {(middle - begin) / kBatch, (end - middle) / kBatch};
}

Figure reporting_figure(std::string where, const std::vector<BatchCost>& costs) {
  std::vector<Nanos> reporting;
  std::vector<Nanos> bare;
  for (const BatchCost& cost : costs) {
    reporting.push_back(cost.reporting);
    bare.push_back(cost.bare);
  }
  return {"report of a run",
          std::move(where),
          kMicros,
          summarize_micros(reporting),
          "the clock readings alone: two of the time, two of the thread's CPU time",
          summarize_micros(bare),
          {.ratio = {}, .p50 = 0.6, .p99 = {}}};
}

Result<Figure> reporting_in_process(const BenchContext& context, Nanos duration) {
  os::Os& os = context.os;
  const Result<std::unique_ptr<SharedApp>> app = SharedApp::make();
  if (!app) return app.error();
  runtime::LocalRegion memory((*app)->graph(), 1);
  const NodeId node = (*app)->node();
  runtime::RingReader reader = memory.region().reports_reader(node);
  std::vector<BatchCost> costs;
  os.spawn("bench-report", [&] {
      static_cast<void>(os.set_affinity(os.current_thread(), os::CpuSet{context.core}));
      runtime::NodePort port(os, (*app)->graph(), node, memory.region());
      ctn::Run run;
      const TimePoint until = os.now() + duration;
      while (os.now() < until) {
        costs.push_back(report_batch(os, port, run, memory.region().node(node).word));
        reader.drain([](auto) {});
      }
    })->join();
  return reporting_figure("in process", costs);
}

void report_when_told(os::Os& os, const SharedApp& app, int cpu) {
  static_cast<void>(os.set_affinity(os.current_thread(), os::CpuSet{cpu}));
  Agreement& agreement = app.agreement();
  runtime::NodePort port(os, app.graph(), app.node(), app.region());
  ctn::Run run;
  for (std::uint32_t turn = 0; await_change(os, agreement.go, turn); ++turn) {
    const BatchCost cost = report_batch(os, port, run, app.region().node(app.node()).word);
    agreement.cost.store(cost.reporting.count());
    agreement.bare_cost.store(cost.bare.count());
    set(os, agreement.done, turn + 1);
  }
}

Result<Figure> reporting_across(const BenchContext& context, Nanos duration) {
  os::Os& os = context.os;
  const Result<std::unique_ptr<SharedApp>> app = SharedApp::make();
  if (!app) return app.error();
  const SharedApp& shared = **app;
  const Peer peer(os, [&] { report_when_told(os, shared, context.core); });
  Agreement& agreement = shared.agreement();
  runtime::RingReader reader = shared.region().reports_reader(shared.node());
  std::vector<BatchCost> costs;
  const TimePoint until = os.now() + duration;
  for (std::uint32_t turn = 0; os.now() < until; ++turn) {
    set(os, agreement.go, turn + 1);
    if (!await_change(os, agreement.done, turn)) return peer_is_gone();
    costs.push_back({Nanos{agreement.cost.load()}, Nanos{agreement.bare_cost.load()}});
    reader.drain([](auto) {});
  }
  return reporting_figure("across processes", costs);
}

Status add(std::vector<Figure>& figures, Result<Figure> figure) {
  if (!figure) return figure.error();
  figures.push_back(std::move(*figure));
  return Done{};
}

}  // namespace

Result<std::vector<Figure>> measure_trigger(const BenchContext& context) {
  std::vector<Figure> figures;
  const Nanos duration = part_of(context, 0.08);
  if (Status done = add(figures, trigger_figure(context, context.core, duration, "same core")); !done)
    return done.error();
  if (!context.other_core) return figures;
  Result<Figure> figure = trigger_figure(context, *context.other_core, duration, "other core, idle");
  if (Status done = add(figures, std::move(figure)); !done) return done.error();
  return figures;
}

Result<std::vector<Figure>> measure_reporting(const BenchContext& context) {
  std::vector<Figure> figures;
  const Nanos duration = part_of(context, 0.02);
  if (Status done = add(figures, reporting_in_process(context, duration)); !done) return done.error();
  if (Status done = add(figures, reporting_across(context, duration)); !done) return done.error();
  return figures;
}

}  // namespace ctn::tool
