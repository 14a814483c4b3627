#include "bench/overhead.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "bench/navigation.h"
#include "bench/peer.h"
#include "catan/client.h"
#include "catan/session.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "runtime/server.h"
#include "synthetic.h"
#include "temporary_folder.h"

namespace ctn::tool {
namespace {

constexpr Nanos kWindow = std::chrono::milliseconds{500};
constexpr Nanos kLongestWarmUp = std::chrono::seconds{20};
constexpr std::uint64_t kSeed = 1;

// By the names that the runtime gives its threads.
struct Kind {
  const char* thread;
  const char* name;
};
constexpr std::array<Kind, 6> kKinds = {{{"catan-core", "dispatchers"},
                                         {"catan-trigger", "triggers"},
                                         {"catan-house", "housekeeper"},
                                         {"catan-server", "server"},
                                         {"catan-heartbeat", "heartbeat"},
                                         {"catan-link", "client"}}};
constexpr std::size_t kHousekeeper = 2;

std::string thread_name(os::ProcessId process, os::ThreadId thread) {
  std::ifstream file(fmt::format("/proc/{}/task/{}/comm", static_cast<int>(process), static_cast<int>(thread)));
  std::string name;
  std::getline(file, name);
  return name;
}

// CPU time by kind, in the order of kKinds.
using Used = std::array<Nanos, kKinds.size()>;

class SchedulerThreads {
 public:
  SchedulerThreads(os::Os& os, const std::vector<os::ProcessId>& processes) : os_(os) {
    for (const os::ProcessId process : processes) {
      const Result<std::vector<os::ThreadId>> threads = os.threads(process);
      if (!threads) continue;
      for (const os::ThreadId thread : *threads) {
        const std::string name = thread_name(process, thread);
        for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
          if (name == kKinds[kind].thread) threads_.emplace_back(thread, kind);
        }
      }
    }
  }

  Used used() const {
    Used total{};
    for (const auto& [thread, kind] : threads_) {
      if (const Result<Nanos> time = os_.thread_cpu_time(thread)) total[kind] += *time;
    }
    return total;
  }

 private:
  os::Os& os_;
  std::vector<std::pair<os::ThreadId, std::size_t>> threads_;
};

Figure percent_figure(std::string name, std::string where, std::vector<double> percent) {
  Figure figure;
  figure.name = std::move(name);
  figure.where = std::move(where);
  figure.unit = kPercent;
  figure.measured = summarize(std::move(percent));
  return figure;
}

// `planning_ms`: CPU time of planning so far. The housekeeping thread spends it, but it is a figure of its own:
// planning may use half of what a minute allows it at once (policy/planning_budget.h), so a few seconds do not tell its
// share.
template <class PlanningTime>
std::vector<Figure> watch(os::Os& os, const SchedulerThreads& threads, Nanos duration, const std::string& where,
                          PlanningTime&& planning_ms) {
  std::array<std::vector<double>, kKinds.size()> by_kind;
  std::vector<double> planning;
  std::vector<double> all;
  const TimePoint until = os.now() + duration;
  TimePoint last = os.now();
  Used before = threads.used();
  double planned_before = planning_ms();
  while (last < until) {
    os.sleep_until(last + kWindow);
    const Used after = threads.used();
    const double planned = planning_ms();
    const TimePoint now = os.now();
    const Millis window = to_millis(now - last);
    planning.push_back(100.0 * ((planned - planned_before) / window.count()));
    double sum = 0.0;
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      double percent = 100.0 * (to_millis(after[kind] - before[kind]) / window);
      if (kind == kHousekeeper) percent = std::max(0.0, percent - planning.back());
      by_kind[kind].push_back(percent);
      sum += percent;
    }
    all.push_back(sum);
    last = now;
    before = after;
    planned_before = planned;
  }
  std::vector<Figure> figures{percent_figure("CPU of scheduling", where, std::move(all))};
  figures.front().goal.p50 = 1.0;
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    Figure figure = percent_figure(fmt::format("  {}", kKinds[kind].name), where, std::move(by_kind[kind]));
    if (figure.measured.max > 0.0) figures.push_back(std::move(figure));
  }
  figures.push_back(percent_figure("planning", where, std::move(planning)));
  return figures;
}

struct Navigation {
  graph::App app;
  model::Workload work;
  std::unique_ptr<TemporaryFolder> folder;

  std::string app_file() const { return folder->path() + "/navigation.yaml"; }
  std::string socket() const { return folder->path() + "/socket"; }
};

Result<Navigation> open_navigation() {
  Result<graph::App> app = config::parse_app(kNavigationApp, "navigation.yaml");
  if (!app) return app.error();
  Result<model::Workload> work = config::parse_workload(kNavigationLoad, "navigation.load.yaml", *app);
  if (!work) return work.error();
  Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::make("catan-bench");
  if (!folder) return folder.error();
  Navigation navigation{std::move(*app), std::move(*work), std::move(*folder)};
  if (!(std::ofstream(navigation.app_file()) << kNavigationApp)) {
    return Error::environment("cannot write " + navigation.app_file(), "make room for a small file there");
  }
  return navigation;
}

// Until its first plan from measured times is in force.
template <class TakeSnapshot>
Status warm_up(os::Os& os, TakeSnapshot&& snapshot) {
  const TimePoint deadline = os.now() + kLongestWarmUp;
  while (!snapshot().warmed_up) {
    if (os.now() >= deadline) {
      return Error::environment("the app did not finish its warm-up",
                                "check whether another program keeps the CPU busy");
    }
    os.sleep_until(os.now() + std::chrono::milliseconds{50});
  }
  return Done{};
}

// The process of the nodes.
void run_nodes(os::Os& os, Navigation& navigation) {
  SyntheticLoad load(navigation.app, navigation.work, kSeed, os);
  Result<Client> client = Client::connect({.socket = navigation.socket(), .app = {}, .on_notice = {}});
  if (!client) return;
  load.attach(*client);
  load.begin();
  if (!client->start()) return;
  for (;;) os.sleep_until(os.now() + std::chrono::seconds{1});  // it is ended
}

}  // namespace

Result<std::vector<Figure>> measure_overhead_in_process(const BenchContext& context) {
  os::Os& os = context.os;
  Result<Navigation> navigation = open_navigation();
  if (!navigation) return navigation.error();
  SyntheticLoad load(navigation->app, navigation->work, kSeed, os);
  SessionOptions options;
  options.cpus = {context.core};
  Result<Session> session = Session::open(navigation->app_file(), options);
  if (!session) return session.error();
  load.attach(*session);
  load.begin();
  if (Status started = session->start(); !started) return started.error();
  if (Status warm = warm_up(os, [&] { return session->snapshot(); }); !warm) return warm.error();
  const SchedulerThreads threads(os, {os.current_process()});
  std::vector<Figure> figures = watch(os, threads, part_of(context, 0.25), "navigation, in process",
                                      [&] { return session->snapshot().planning_ms; });
  load.stop();
  if (Status stopped = session->stop(); !stopped) return stopped.error();
  return figures;
}

Result<std::vector<Figure>> measure_overhead_served(const BenchContext& context) {
  os::Os& os = context.os;
  Result<Navigation> navigation = open_navigation();
  if (!navigation) return navigation.error();
  const Peer nodes(os, [&] { run_nodes(os, *navigation); });
  runtime::ServerOptions options;
  options.scheduler.policy = *policy::make_policy("catan");
  options.scheduler.cpus = os::CpuSet{context.core};
  options.socket = navigation->socket();
  Result<config::AppFile> file = config::load_app_file(navigation->app_file());
  if (!file) return file.error();
  Result<std::unique_ptr<runtime::Server>> server = runtime::Server::open(std::move(*file), os, std::move(options));
  if (!server) return server.error();
  if (Status started = (*server)->start(); !started) return started.error();
  const auto thread = os.spawn("catan-server", [&] { (*server)->run(); });
  Status warm = warm_up(os, [&] { return (*server)->snapshot(); });
  std::vector<Figure> figures;
  if (warm) {
    const SchedulerThreads threads(os, {os.current_process(), nodes.process()});
    figures = watch(os, threads, part_of(context, 0.25), "navigation, served",
                    [&] { return (*server)->snapshot().planning_ms; });
  }
  (*server)->stop();
  thread->join();
  const Status finished = (*server)->finish();
  if (!warm) return warm.error();
  if (!finished) return finished.error();
  return figures;
}

}  // namespace ctn::tool
