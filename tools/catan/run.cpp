// catan run: runs an app for a while and shows what it came to.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>

#include "base/text.h"
#include "catan/session.h"
#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "os/linux/linux_os.h"
#include "record/reader.h"
#include "report/json.h"
#include "report/metrics.h"
#include "report/text.h"
#include "synthetic.h"

namespace ctn::tool {
namespace {

struct Options {
  std::string app;
  std::string synthetic;
  std::string scheduler = "catan";
  std::string cpus;
  std::string record;
  double seconds = 10.0;
  std::uint64_t seed = 1;
  bool no_stealing = false;
  bool no_replan = false;
  std::string frames;
  bool json = false;
};

volatile std::sig_atomic_t g_signal = 0;
void remember_signal(int number) { g_signal = number; }

// As CLI::Range, which lets NaN through.
CLI::Validator within(double least, double most) {
  const auto check = [=](const std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return {};
    return fmt::format("{} is no number from {} to {}", quote(text), least, most);
  };
  return {check, fmt::format("from {} to {}", least, most)};
}

// A folder for what nobody asked to keep; removed with all that is in it.
class TemporaryFolder {
 public:
  static Result<std::unique_ptr<TemporaryFolder>> make() {
    std::error_code error;
    const std::filesystem::path parent = std::filesystem::temp_directory_path(error);
    std::string path = (parent / "catan-run-XXXXXX").string();
    if (error || mkdtemp(path.data()) == nullptr) {
      return Error::environment("there is no place for temporary files in " + parent.string(),
                                "set TMPDIR, or keep the record with --record FILE");
    }
    return std::unique_ptr<TemporaryFolder>(new TemporaryFolder(std::move(path)));
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

// The live line on a terminal; nothing where stderr is none.
class StatusLine {
 public:
  ~StatusLine() { show({}); }
  void show(const std::string& line) const {
    if (terminal_) fmt::print(stderr, "\r\033[K{}", line);
  }

 private:
  bool terminal_ = isatty(STDERR_FILENO) == 1;
};

std::string status_text(const Snapshot& snapshot, double measured_s, double seconds) {
  if (!snapshot.warmed_up) return "warming up";
  std::string line = fmt::format("{:.1f} of {:.6g} s", measured_s, seconds);
  if (snapshot.chains.empty()) return line;
  const ChainSnapshot& chain = snapshot.chains.front();
  line += fmt::format("  {:.1f} Hz  response {:.4g} ms", snapshot.source_hz, chain.response_ms.mean);
  if (chain.predicted_response_ms) line += fmt::format(" (predicted {:.4g})", *chain.predicted_response_ms);
  return line;
}

// Waits for the warm-up and then for the time to measure, or for a signal. Whether anything was measured.
bool let_run(const Session& session, os::Os& os, double seconds) {
  constexpr Nanos kStep = std::chrono::milliseconds{20};
  constexpr int kStepsToShow = 25;
  const StatusLine status;
  std::optional<TimePoint> warm;
  for (int step = 0; g_signal == 0; ++step) {
    std::this_thread::sleep_for(kStep);
    const double measured = warm ? std::chrono::duration<double>(os.now() - *warm).count() : 0.0;
    if (measured >= seconds) return true;
    if (warm && step % kStepsToShow != 0) continue;
    const Snapshot snapshot = session.snapshot();
    if (!warm && snapshot.warmed_up) warm = os.now();
    if (step % kStepsToShow == 0) status.show(status_text(snapshot, measured, seconds));
  }
  return warm.has_value();
}

// What the figures do not say by themselves.
void note_limits(const graph::App& app, const Options& options) {
  if (options.scheduler != "catan") return;
  std::vector<std::string> parallel;
  for (const graph::Node& node : app.graph.nodes()) {
    if (!node.external && node.max_threads > 1) parallel.push_back(node.name);
  }
  if (parallel.empty()) return;
  note(fmt::format("{} may use several threads, but a synthetic load burns on one: predictions for more do not hold",
                   fmt::join(parallel, ", ")));
}

Result<SessionOptions> session_options(const Options& options, const std::string& record) {
  SessionOptions result;
  result.policy = options.scheduler;
  result.record = record;
  result.stealing = !options.no_stealing;
  result.replan = !options.no_replan;
  if (!options.frames.empty()) result.fixed_frames = options.frames == "fixed";
  result.note = fmt::format("synthetic load {}, seed {}", options.synthetic, options.seed);
  if (options.cpus.empty()) return result;
  const auto cpus = os::parse_cpu_list(options.cpus);
  if (!cpus) {
    Problem problem = cpus.error().problems().front();
    problem.key = "--cpus";
    return Error(ErrorKind::kCaller, {std::move(problem)});
  }
  result.cpus = cpus->cpus();
  return result;
}

// Whether the warm-up ended before the run did.
Result<bool> run_synthetic(const graph::App& app, const Options& options, const std::string& record_path) {
  auto work = config::load_workload(options.synthetic, app);
  if (!work) return work.error();
  const auto configured = session_options(options, record_path);
  if (!configured) return configured.error();
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  SyntheticLoad load(app, std::move(*work), options.seed, *os);
  auto session = Session::open(options.app, *configured);
  if (!session) return session.error();
  load.attach(*session);
  load.begin();
  if (Status started = session->start(); !started) return started.error();
  note_limits(app, options);
  const bool warm = let_run(*session, *os, options.seconds);
  load.stop();
  if (Status stopped = session->stop(); !stopped) return stopped.error();
  return warm;
}

int show(const std::string& record_path, bool warm, bool json) {
  const auto record = record::Reader::open(record_path);
  if (!record) return report_error(record.error());
  const auto metrics = report::measure(*record, !warm);
  if (!metrics) return report_error(metrics.error());
  print(json ? report::to_json(*metrics) : report::to_text(*metrics));
  return kSuccess;
}

int run(const Options& options) {
  const auto app = config::load_app(options.app);
  if (!app) return report_error(app.error());
  if (options.synthetic.empty()) {
    return report_error(
        Error::caller("this version runs an app only with a synthetic load",
                      "give --synthetic COSTS, or write a program with the app's code (include/catan/session.h)"));
  }
  std::unique_ptr<TemporaryFolder> folder;
  std::string record_path = options.record;
  if (record_path.empty()) {
    auto made = TemporaryFolder::make();
    if (!made) return report_error(made.error());
    folder = std::move(*made);
    record_path = folder->path() + "/run.catan";
  }
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, remember_signal);
  const auto warm = run_synthetic(*app, options, record_path);
  if (!warm) return report_error(warm.error());
  if (const int shown = show(record_path, *warm, options.json); shown != kSuccess) return shown;
  return g_signal == 0 ? kSuccess : 128 + g_signal;
}

}  // namespace

void add_run_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = cli.add_subcommand("run", "Run an app for a while and show what it came to");
  command->footer(
      "Examples:\n"
      "  catan run app.yaml --synthetic costs.yaml                        each node burns CPU time as the cost file "
      "says\n"
      "  catan run app.yaml --synthetic costs.yaml --cpus 0,1 --seconds 30 --record run.catan\n"
      "  catan run app.yaml --synthetic costs.yaml --scheduler rate:20Hz  to compare with\n"
      "  catan run app.yaml --synthetic costs.yaml --json                 the document of catan report --json\n"
      "Ctrl-C ends the run early: what was measured is shown, and the exit code is 128 + the signal's number.\n"
      "docs/synthetic-load.md says what is measured and how the load behaves.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--synthetic", options->synthetic, "Burn CPU time as this cost file says (docs/cost-file.md)")
      ->type_name("COSTS");
  command->add_option("--seconds", options->seconds, "How long to measure, after the warm-up")
      ->check(within(0.1, 864'000.0))
      ->capture_default_str();
  command
      ->add_option("--scheduler", options->scheduler,
                   "catan; static:PLAN.json (a plan that is never revised); default (each subchain at its "
                   "fallback_rate, ordinary scheduling); rate:HZ (sources at it); fifo (as default, at fixed "
                   "real-time priorities)")
      ->capture_default_str();
  command->add_option("--cpus", options->cpus, "CPUs for the nodes, as in 0-3,6; else all that may be used")
      ->type_name("LIST");
  command->add_option("--record", options->record, "Keep the record of the run in this new file (catan report)")
      ->type_name("FILE");
  command->add_option("--seed", options->seed, "Of the draws: equal seeds, equal draws")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_flag("--no-stealing", options->no_stealing, "Nobody goes on in another's slot when late");
  command->add_flag("--no-replan", options->no_replan, "Keep the first plan that rests on measured times");
  command->add_option("--frames", options->frames, "Frames of shared cores; else as the app says")
      ->check(CLI::IsMember({"elastic", "fixed"}));
  command->add_flag("--json", options->json, "Print one JSON document");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace ctn::tool
