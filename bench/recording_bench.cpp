// What records and the flight recorder cost, and whether losses are reported. docs/benchmarks.md says how to read the
// output.
//
//   the writer   CPU time of record/writer.h for runs with an input, triggers and slots, which it gets as from the
//                housekeeping thread: in steps of 50 ms, committed once a second. Beside it, CPU time of the flight
//                recorder for the same
//   a server     CPU time of the housekeeping thread of a served app, in turn with nothing kept, with the flight
//                recorder, and with a record as well. Subchains are triggered a thousand times a second, and nodes of
//                programs report runs by themselves, as many as are missing to the rate. Also how many of the runs
//                that were reported are in the record, and how many the record says were lost
//
// Usage: recording_bench [--rate N]... [--seconds N] [--rounds N]; rates are events a second. Exit code: 1 if losses
// were not reported, 0 otherwise, however long it took.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "catan/client.h"
#include "config/app_file.h"
#include "flight/recorder.h"
#include "os/linux/forked_process.h"
#include "os/linux/linux_os.h"
#include "policy/policy.h"
#include "record/reader.h"
#include "record/run_metrics.h"
#include "record/writer.h"
#include "runtime/server.h"
#include "value_of.h"

namespace {

using namespace ctn;
using bench::value_of;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kSteps = 20;         // a second, as in the housekeeping thread
constexpr int kFree = 10;          // nodes that report runs by themselves
constexpr int kTriggered = 5;      // subchains
constexpr int kTriggersHz = 1000;  // of each

// Events a second for the writer alone: at higher rates an event costs much the same.
constexpr int kMaxWritten = 200'000;

struct Options {
  std::vector<int> rates;
  int seconds = 5;
  int rounds = 3;
};

// A folder that is removed, with all that is in it, at the end.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "recording-bench-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no folder can be made for records");
    path_ = pattern;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// Half of the free nodes and all triggered ones take the output of another node.
std::string app_text() {
  std::string nodes;
  std::string edges;
  std::string subchains;
  for (int i = 0; i < kFree; ++i) {
    nodes += fmt::format("  free{}: {{ unscheduled: true, period: 1ms }}\n", i);
    if (i >= kFree / 2) edges += fmt::format("  - free{} -> free{}\n", i - kFree / 2, i);
  }
  for (int i = 0; i < kTriggered; ++i) {
    nodes += fmt::format("  triggered{}: {{ fallback_rate: {}Hz }}\n", i, kTriggersHz);
    edges += fmt::format("  - free{0} -> triggered{0}\n", i);
  }
  return "catan: 1\napp: recording\nnodes:\n" + nodes + "edges:\n" + edges +
         "objective:\n  - { period: triggered0, weight: 1 }\n";
}

double median(std::vector<double> values) { return summarize(std::move(values)).p50; }

// --- The writer ---

struct Written {
  double percent = 0.0;     // of a core
  double micros = 0.0;      // of CPU time for each event
  double bytes = 0.0;       // for each event
  double longest_ms = 0.0;  // the longest commit, in time of the clock
};

enum class Kind { kRuns, kTriggers, kSlots, kAll };

// Gives a sink the events of a step of 50 ms, and then lets it do what it does at the end of a step.
template <class EndOfStep>
Written feed(os::Os& os, const graph::App& app, record::Sink& to, Kind kind, int rate, int for_seconds,
             const EndOfStep& end_of_step) {
  const NodeId from = *app.graph.find_node("free0");
  const NodeId node = *app.graph.find_node("free5");
  std::uint64_t number = 0;
  Written written;
  const Nanos before = os.thread_cpu_time();
  for (int step = 0; step < for_seconds * kSteps; ++step) {
    for (int i = 0; i < rate / kSteps; ++i) {
      const std::uint64_t which = kind == Kind::kAll ? number % 3 : static_cast<std::uint64_t>(kind);
      const TimePoint at = TimePoint{} + ++number * Nanos{seconds{1}} / static_cast<std::uint64_t>(rate);
      const TimePoint end = at + std::chrono::microseconds{20};
      if (which == 0) {
        record::Run run;
        run.node = node;
        run.number = number;
        run.begin = at;
        run.end = end;
        run.cpu = std::chrono::microseconds{15};
        run.consumed.push_back({from, number, number});
        run.on_cpu = 1;
        to.add(run);
      } else if (which == 1) {
        to.add(record::Trigger{SubchainId{0}, number, at, end});
      } else {
        to.add(record::SlotUse{0, SubchainId{0}, at, at, end});
      }
    }
    end_of_step(step, written);
  }
  const Nanos used = os.thread_cpu_time() - before;
  written.percent = 100.0 * to_millis(used).count() / (1000.0 * for_seconds);
  written.micros = 1000.0 * to_millis(used).count() / static_cast<double>(number);
  return written;
}

Written write(os::Os& os, const graph::App& app, const std::string& path, Kind kind, int rate, int for_seconds) {
  auto writer = value_of(record::Writer::create(path, app, {}));
  Written written = feed(os, app, *writer, kind, rate, for_seconds, [&](int step, Written& so_far) {
    if ((step + 1) % kSteps != 0) return;
    const TimePoint begin = os.now();
    if (Status done = writer->flush(); !done) throw std::runtime_error(done.error().message());
    so_far.longest_ms = std::max(so_far.longest_ms, to_millis(os.now() - begin).count());
  });
  if (Status done = writer->close(TimePoint{} + seconds{for_seconds}, {}); !done) {
    throw std::runtime_error(done.error().message());
  }
  written.bytes = static_cast<double>(std::filesystem::file_size(path)) / (1.0 * rate * for_seconds);
  std::filesystem::remove(path);
  return written;
}

Written keep(os::Os& os, const graph::App& app, Kind kind, int rate, int for_seconds) {
  const auto recorder =
      value_of(flight::Recorder::create(app, {}, os.current_process(), flight::Recorder::kDefaultBytes));
  return feed(os, app, *recorder, kind, rate, for_seconds, [&](int, Written&) { recorder->show_alive(os.now()); });
}

void measure_writer(os::Os& os, const graph::App& app, const Options& options, const Folder& folder) {
  fmt::print(
      "The writer of records, in steps of 50 ms, committed once a second, and the flight recorder, in turn: "
      "medians of {} rounds of {} s\n",
      options.rounds, options.seconds);
  fmt::print("{:>10}  {:<10} {:>9} {:>9} {:>12} {:>17} {:>17} {:>9}\n", "events/s", "of them", "% of core", "us/event",
             "bytes/event", "longest commit ms", "% flight recorder", "us/event");
  for (const int rate : options.rates) {
    if (rate > kMaxWritten) continue;
    for (const auto& [kind, name] : {std::pair{Kind::kRuns, "runs"}, std::pair{Kind::kTriggers, "triggers"},
                                     std::pair{Kind::kSlots, "slots"}, std::pair{Kind::kAll, "all three"}}) {
      std::vector<double> percent;
      std::vector<double> micros;
      std::vector<double> kept_percent;
      std::vector<double> kept_micros;
      Written last;
      double longest_ms = 0.0;
      for (int round = 0; round < options.rounds; ++round) {
        last = write(os, app, folder.file("writer.catan"), kind, rate, options.seconds);
        percent.push_back(last.percent);
        micros.push_back(last.micros);
        longest_ms = std::max(longest_ms, last.longest_ms);
        const Written kept = keep(os, app, kind, rate, options.seconds);
        kept_percent.push_back(kept.percent);
        kept_micros.push_back(kept.micros);
      }
      fmt::print("{:>10}  {:<10} {:>9.2f} {:>9.2f} {:>12.1f} {:>17.1f} {:>17.2f} {:>9.3f}\n", rate, name,
                 median(percent), median(micros), last.bytes, longest_ms, median(kept_percent), median(kept_micros));
    }
  }
}

// --- A server ---

// The process of the nodes, which runs until it is killed.
int run_nodes(os::Os& os, const std::string& socket, int rate) {
  auto client = value_of(Client::connect({.socket = socket, .app = {}, .on_notice = {}}));
  for (int i = 0; i < kTriggered; ++i) client.node(fmt::format("triggered{}", i), [](Run&) {});
  if (Status done = client.start(); !done) return 1;
  // Each triggered node makes two events, a trigger and a run; all others are runs of free nodes.
  const int each_ms = std::max(1, (rate - 2 * kTriggered * kTriggersHz) / kFree / 1000);
  std::vector<std::thread> threads;
  for (int i = 0; i < kFree; ++i) {
    threads.emplace_back([&client, &os, i, each_ms] {
      Run run;
      auto node = client.attach(fmt::format("free{}", i));
      if (!node) return fmt::print(stderr, "recording_bench: {}\n", node.error().message());
      for (TimePoint next = os.now();; os.sleep_until(next += milliseconds{1})) {
        for (int one = 0; one < each_ms; ++one) {
          node->begin(run);
          node->end(run);
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  return 0;
}

std::optional<os::ThreadId> housekeeping_thread(os::Os& os) {
  const auto threads = os.threads(os.current_process());
  if (!threads) return std::nullopt;
  for (const os::ThreadId thread : *threads) {
    std::ifstream file(fmt::format("/proc/self/task/{}/comm", static_cast<int>(thread)));
    std::string name;
    if (std::getline(file, name) && name == "catan-house") return thread;
  }
  return std::nullopt;
}

struct Served {
  double percent = 0.0;  // of a core, used by the housekeeping thread
  std::string cpus;      // where it may run
  record::Interval measured{};
};

struct Kept {
  std::string record;  // file; empty: none
  std::size_t flight_bytes = 0;
};

Served serve(os::Os& os, const std::string& socket, const Kept& kept, int rate, int for_seconds) {
  const os::ForkedProcess nodes([&] { return run_nodes(os, socket, rate); });  // forked before this process has threads
  runtime::ServerOptions options;
  options.scheduler.policy = *policy::make_policy("default");
  options.scheduler.record = kept.record;
  options.scheduler.flight_bytes = kept.flight_bytes;
  options.socket = socket;
  const std::string text = app_text();
  auto server = value_of(
      runtime::Server::open({text, value_of(config::parse_app(text, "recording.yaml"))}, os, std::move(options)));
  if (Status done = server->start(); !done) throw std::runtime_error(done.error().message());
  const auto thread = os.spawn("catan-server", [&] { server->run(); });
  os.sleep_until(os.now() + seconds{1});  // by then all nodes have registered
  Served served;
  if (const auto house = housekeeping_thread(os)) {
    const auto cpus = os.affinity(*house);
    served.cpus = cpus ? os::to_string(*cpus) : "unknown";
    const auto before = os.thread_cpu_time(*house);
    served.measured.begin = os.now();
    os.sleep_until(served.measured.begin + seconds{for_seconds});
    const auto after = os.thread_cpu_time(*house);
    served.measured.end = os.now();
    if (before && after) {
      served.percent = 100.0 * (to_millis(*after - *before) / to_millis(served.measured.end - served.measured.begin));
    }
  }
  server->stop();
  thread->join();
  if (Status done = server->finish(); !done) throw std::runtime_error(done.error().message());
  return served;
}

struct Counted {
  std::uint64_t events = 0;   // runs and triggers that were measured
  std::uint64_t missing = 0;  // runs that were reported, as far as their numbers tell, and are not in the record
  std::uint64_t told = 0;     // reports that the record says were lost
};

Counted count(const std::string& path, const record::Interval& measured) {
  const auto record = value_of(record::Reader::open(path));
  Counted counted;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> runs(record.app().graph.nodes().size());  // how many, the last
  Status done = record.each_run([&](const record::Run& run) {
    auto& [recorded, last] = runs[run.node.index()];
    ++recorded;
    counted.events += measured.holds(run.end, run.end) ? 1U : 0U;
    last = std::max(last, run.number);
  });
  if (done) {
    done = record.each_trigger([&](const record::Trigger& trigger) {
      counted.events += measured.holds(trigger.sent, trigger.sent) ? 1U : 0U;
    });
  }
  if (!done) throw std::runtime_error(done.error().message());
  for (const auto& [recorded, last] : runs) counted.missing += last - recorded;
  for (const record::Notice& notice : value_of(record.notices())) {
    std::uint64_t lost = 0;
    if (notice.kind != "lost-reports") continue;
    std::from_chars(notice.detail.data(), notice.detail.data() + notice.detail.size(), lost);
    counted.told = std::max(counted.told, lost);  // each notice says how many in all so far
  }
  return counted;
}

// False: more reports were lost than the record says.
bool measure_server(os::Os& os, const Options& options, const Folder& folder) {
  fmt::print(
      "\nThe housekeeping thread of a server that keeps nothing, has a flight recorder, and a record as well, in "
      "turn: medians of {} rounds of {} s\n",
      options.rounds, options.seconds);
  fmt::print("{:>10} {:>9} {:>9} {:>10} {:>9} {:>8}  {:<8} {:>12} {:>9} {:>9}\n", "events/s", "% nothing", "% flight",
             "difference", "% record", "more", "its CPUs", "in record/s", "missing", "told");
  bool all_told = true;
  for (const int rate : options.rates) {
    std::vector<double> recorded;
    std::vector<double> flight;
    std::vector<double> nothing;
    Counted sum;
    std::string cpus;
    for (int round = 0; round < options.rounds; ++round) {
      const std::string record = folder.file(fmt::format("served-{}-{}.catan", rate, round));
      const auto serve_with = [&](const Kept& kept) {
        return serve(os, folder.file("socket"), kept, rate, options.seconds);
      };
      nothing.push_back(serve_with({}).percent);
      flight.push_back(serve_with({{}, flight::Recorder::kDefaultBytes}).percent);
      const Served served = serve_with({record, flight::Recorder::kDefaultBytes});
      recorded.push_back(served.percent);
      cpus = served.cpus;
      const Counted counted = count(record, served.measured);
      sum.events += counted.events;
      sum.missing += counted.missing;
      sum.told += counted.told;
      all_told = all_told && counted.told >= counted.missing;
      std::filesystem::remove(record);
    }
    fmt::print("{:>10} {:>9.2f} {:>9.2f} {:>10.2f} {:>9.2f} {:>8.2f}  {:<8} {:>12.0f} {:>9} {:>9}\n", rate,
               median(nothing), median(flight), median(flight) - median(nothing), median(recorded),
               median(recorded) - median(flight), cpus,
               static_cast<double>(sum.events) / (1.0 * options.rounds * options.seconds), sum.missing, sum.told);
  }
  return all_told;
}

bool read(int argc, char** argv, Options& options) {
  for (int at = 1; at + 1 < argc; at += 2) {
    const std::string word = argv[at];
    const std::string value = argv[at + 1];
    int number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size() || number < 1) return false;
    if (word == "--rate") {
      options.rates.push_back(number);
    } else if (word == "--seconds") {
      options.seconds = number;
    } else if (word == "--rounds") {
      options.rounds = number;
    } else {
      return false;
    }
  }
  if (options.rates.empty()) options.rates = {20'000, 200'000, 1'000'000};
  return argc % 2 == 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!read(argc, argv, options)) {
    fmt::print(stderr, "Usage: recording_bench [--rate N]... [--seconds N] [--rounds N]\n");
    return 2;
  }
  try {
    std::setvbuf(stdout, nullptr, _IOLBF, 0);  // so that no forked copy of this process has text left to print
    const auto os = os::make_linux_os();
    const Folder folder;
    const graph::App app = value_of(config::parse_app(app_text(), "recording.yaml"));
    measure_writer(*os, app, options, folder);
    return measure_server(*os, options, folder) ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "recording_bench: {}\n", error.what());
    return 1;
  }
}
