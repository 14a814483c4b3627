// catan run: runs an app for a while and shows what it came to.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/session_access.h"
#include "base/text.h"
#include "catan/session.h"
#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "os/linux/linux_os.h"
#include "scheduling_options.h"
#include "serving_programs.h"
#include "shown_record.h"
#include "status_line.h"
#include "synthetic.h"
#include "temporary_folder.h"
#include "watch.h"

namespace ctn::tool {
namespace {

struct RunOptions {
  std::string app;
  std::string synthetic;
  std::vector<std::string> command;
  bool processes = false;
  SchedulingOptions scheduling;
  WatchedApp watched;
  std::optional<double> seconds;
  std::uint64_t seed = 1;
  bool json = false;

  double seconds_to_measure() const { return seconds.value_or(10.0); }
};

volatile std::sig_atomic_t g_signal = 0;
void remember_signal(int number) { g_signal = number; }

// Waits for the warm-up and then for the time to measure, or for a signal. Whether anything was measured.
bool let_run(const Session& session, os::Os& os, double seconds) {
  constexpr Nanos kStep = std::chrono::milliseconds{20};
  constexpr int kStepsToShow = 25;
  const StatusLine status;
  std::optional<TimePoint> warm;
  for (int step = 0; g_signal == 0; ++step) {
    std::this_thread::sleep_for(kStep);
    const double measured = warm ? in_seconds(os.now() - *warm) : 0.0;
    if (measured >= seconds) return true;
    if (warm && (!status.shown() || step % kStepsToShow != 0)) continue;
    const Snapshot snapshot = session.snapshot();
    if (!warm && snapshot.warmed_up) warm = os.now();
    if (step % kStepsToShow == 0) status.show(status_text(snapshot, measured, seconds));
  }
  return warm.has_value();
}

std::string load_note(const RunOptions& options) {
  return fmt::format("synthetic load {}, seed {}", options.synthetic, options.seed);
}

// Whether the warm-up ended before the run did.
Result<bool> run_synthetic(const graph::App& app, const RunOptions& options, const std::string& record_path) {
  auto work = config::load_workload(options.synthetic, app);
  if (!work) return work.error();
  auto configured = options.scheduling.for_session(record_path);
  if (!configured) return configured.error();
  configured->note = load_note(options);
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  SyntheticLoad load(app, std::move(*work), options.seed, *os);
  auto session = SessionAccess::open(app, *configured);
  if (!session) return session.error();
  load.attach(*session);
  load.begin();
  if (Status started = session->start(); !started) return started.error();
  if (Status added = load.add_threads(*session); !added) return added.error();
  std::optional<os::ChildProcess> watcher;
  if (!options.watched.on_late.empty()) {
    Result<os::ChildProcess> watching = options.watched.start_watching(std::to_string(::getpid()));
    if (!watching) return watching.error();
    watcher.emplace(std::move(*watching));
  }
  const bool warm = let_run(*session, *os, options.seconds_to_measure());
  load.stop();
  const Status stopped = session->stop();
  if (watcher) options.watched.let_end(*os, *watcher);
  if (!stopped) return stopped.error();
  return warm;
}

// A program that plays nodes, one for each subchain and each unscheduled node.
std::vector<std::vector<std::string>> node_programs(const graph::App& app, const RunOptions& options) {
  std::vector<std::vector<std::string>> programs;
  const auto add = [&](const std::vector<NodeId>& nodes) {
    std::vector<std::string>& program = programs.emplace_back();
    program = {"/proc/self/exe", "node", options.app};
    for (const NodeId node : nodes) program.push_back(app.graph.node(node).name);
    for (const std::string& argument :
         {std::string("--synthetic"), options.synthetic, std::string("--seed"), std::to_string(options.seed)}) {
      program.push_back(argument);
    }
  };
  for (const graph::Subchain& subchain : app.graph.subchains()) add(subchain.nodes);
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    if (app.graph.nodes()[index].unscheduled) add({NodeId(index)});
  }
  return programs;
}

// Serves the app to programs, which it starts.
Result<Served> run_programs(const config::AppFile& file, const RunOptions& options, const std::string& record_path,
                            const std::string& folder) {
  ServingOptions serving;
  serving.socket = folder + "/socket";
  serving.prints_data = options.json;
  if (options.processes) {
    serving.commands = node_programs(file.app, options);
    serving.seconds = options.seconds_to_measure();
  } else {
    serving.commands = {options.command};
    serving.seconds = options.seconds;
  }
  std::string remark = options.processes ? load_note(options) : fmt::format("{}", fmt::join(options.command, " "));
  return serve_programs(file, options.scheduling, options.watched, record_path, std::move(serving), std::move(remark));
}

Status check_combination(const RunOptions& options) {
  std::vector<Problem> problems;
  if (options.synthetic.empty() == options.command.empty()) {
    problems.push_back(
        {{}, {}, "what is to run is not said, or said twice", "give either --synthetic COSTS or -- COMMAND..."});
  }
  if (options.processes && options.synthetic.empty()) {
    problems.push_back(
        {{}, "--processes", "only a synthetic load can be spread over processes", "give --synthetic COSTS"});
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return Done{};
}

int run(const RunOptions& options) {
  outlive_readers();
  if (Status possible = check_combination(options); !possible) return report_error(possible.error());
  const config::RunBy run_by = options.synthetic.empty() ? config::RunBy::kBoundPrograms : config::RunBy::kFunctions;
  const auto file = config::load_app_file(options.app, run_by);
  if (!file) return report_error(file.error());
  if (Status fits = options.watched.check(file->app, options.scheduling.flight_recorder_mib); !fits) {
    return report_error(fits.error());
  }
  const auto folder = TemporaryFolder::make("catan-run");
  if (!folder) return report_error(folder.error());
  const std::string record_path =
      options.scheduling.record.empty() ? (*folder)->path() + "/run.catan" : options.scheduling.record;
  if (options.processes || !options.command.empty()) {
    const auto served = run_programs(*file, options, record_path, (*folder)->path());
    if (!served) return report_error(served.error());
    return show_served(*served, record_path, options.json);
  }
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, remember_signal);
  const auto warm = run_synthetic(file->app, options, record_path);
  if (!warm) return report_error(warm.error());
  if (const int shown = show_record(record_path, *warm, options.json); shown != kSuccess) return shown;
  return g_signal == 0 ? kSuccess : 128 + g_signal;
}

}  // namespace

void add_run_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = cli.add_subcommand("run", "Run an app for a while and show what it came to");
  command->footer(
      "Examples:\n"
      "  catan run app.yaml --synthetic costs.yaml                        each node burns CPU time as the cost file "
      "says\n"
      "  catan run app.yaml --synthetic costs.yaml --cpus 0,1 --seconds 30 --record run.catan\n"
      "  catan run app.yaml --synthetic costs.yaml --scheduler rate:20Hz  to compare with\n"
      "  catan run app.yaml --synthetic costs.yaml --json                 the document of catan report --json\n"
      "  catan run app.yaml --synthetic costs.yaml --processes            the same, in a process for each subchain\n"
      "  catan run app.yaml -- ros2 launch my_robot all.launch.py         serves the app, starts the command, ends "
      "with "
      "it\n"
      "  catan run app.yaml --synthetic costs.yaml --on-late 'LP>150'     saves the last seconds when that is late\n"
      "Ctrl-C ends the run early, and what was measured is shown. docs/synthetic-load.md says what is measured and "
      "how\n"
      "the load behaves.\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake, 128 + the signal's number if a signal ended it. With\n"
      "COMMAND it is COMMAND's, where Catan did what it was asked.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--synthetic", options->synthetic, "Burn CPU time as this cost file says (docs/cost-file.md)")
      ->type_name("COSTS");
  command->add_flag("--processes", options->processes, "A process for each subchain, in place of one for all");
  command
      ->add_option("--seconds", options->seconds,
                   "How long to measure, after the warm-up; else 10 s, or as long as COMMAND runs")
      ->check(within(0.1, 864'000.0));
  command->add_option("--seed", options->seed, "Of the draws: equal seeds, equal draws")
      ->check(CLI::NonNegativeNumber)
      ->needs("--synthetic")
      ->capture_default_str();
  options->scheduling.add_to(*command);
  options->watched.add_to(*command);
  command->add_option("COMMAND", options->command, "Starts the app's programs, which find the server by CATAN_SOCKET")
      ->type_name("-- COMMAND...");
  command->add_flag("--json", options->json, "Print one JSON document");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace ctn::tool
