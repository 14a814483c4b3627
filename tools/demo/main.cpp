// catan_demo: runs face_tracking under default, Catan and a sweep of source rates, and writes what came out.

#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include <CLI/CLI.hpp>

#include "experiment.h"
#include "experiments/host.h"
#include "look.h"
#include "page.h"
#include "report/plot.h"
#include "results.h"
#include "runner.h"

namespace ctn::demo {
namespace {

constexpr int kFailure = 1;
constexpr int kMistake = 2;

volatile std::sig_atomic_t g_signal = 0;
void remember_signal(int number) { g_signal = number; }

struct Options {
  std::string program;
  std::string out = "out/demo";
  std::string from;  // results to render again; empty: run
  Setting setting;
  bool check = false;
  int failed = 0;  // the exit code of a trial that went wrong after others had gone well

  FaceTracking face_tracking() const {
    const std::filesystem::path folder = out;
    return {program, setting.slowdown, (folder / "faces.png").string(), (folder / "face_tracking.log").string()};
  }
};

int fail(const Error& error) {
  fmt::print(stderr, "catan_demo: {}\n", error.message());
  return error.kind() == ErrorKind::kCaller ? kMistake : kFailure;
}

Status write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) return Error::environment("cannot write " + path.string(), "check the folder's rights and the disk");
  return Done{};
}

Status write_all(const Results& results, const Options& options) {
  const std::filesystem::path folder = options.out;
  if (Status done = write_file(folder / "results.json", to_json(results)); !done) return done;
  const Summary summary = summarise(results);
  const std::pair<const char*, report::Figure> figures[] = {
      {"response_time.svg", response_figure(summary, results.medium_speed)},
      {"angle.svg", angle_figure(summary, results.medium_speed)}};
  for (const auto& [name, figure] : figures) {
    const Result<std::string> svg = report::render_svg(figure, report::SvgUse::kStandalone);
    if (!svg) return svg.error();
    if (Status done = write_file(folder / name, *svg); !done) return done;
  }
  const Result<std::optional<page::Glance>> glance = write_look(folder, options.setting);
  if (!glance) return glance.error();
  const Result<std::string> page = render_page(results, *glance);
  if (!page) return page.error();
  return write_file(folder / "report.html", *page);
}

// Progress on stderr: which trial, what came out, how long it will still take.
class Progress {
 public:
  explicit Progress(std::size_t count) : count_(count) {}

  void begin(const Trial& trial) {
    const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double left = done_ == 0 ? 0.0 : passed / static_cast<double>(done_) * static_cast<double>(count_ - done_);
    const std::string eta =
        done_ == 0 ? "" : fmt::format(", {}:{:02d} left", static_cast<int>(left) / 60, static_cast<int>(left) % 60);
    fmt::print(stderr, "[{:>2}/{}{}] {} core{}, {:.1f} rad/s, {:<12} ", done_ + 1, count_, eta, trial.cpus.size(),
               trial.cpus.size() == 1 ? " " : "s", trial.speed, trial.scheduler);
    std::fflush(stderr);
  }
  void end(const Measured& run) {
    ++done_;
    fmt::print(stderr, "response {:6.1f} ms  angle {:5.2f} deg\n", run.response_ms, run.angle_deg);
  }

 private:
  std::size_t count_;
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// What the nodes cost here, which says where to sweep, and what a trial takes beside what it measures: the second of
// two short trials that do not count. The first finds the film's faces for all that follow.
Result<Compute> calibrate(Options& options) {
  fmt::print(stderr, "measuring what the nodes cost ... ");
  const Trial trial{0, options.setting.cpu_sets.front(), "catan", options.setting.medium_speed,
                    1, options.setting.slowdown};
  const Result<Measured> first = run_trial(options.face_tracking(), trial);
  if (!first) return first.error();
  const auto start = std::chrono::steady_clock::now();
  const Result<Measured> run = run_trial(options.face_tracking(), trial);
  if (!run) return run.error();
  const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  options.setting.overhead = passed - trial.seconds;
  fmt::print(stderr, "camera {:.1f} ms, detect {:.1f} ms, plan {:.1f} ms\n", run->compute.camera, run->compute.detect,
             run->compute.plan);
  return run->compute;
}

// What goes wrong here takes nothing from the results.
void take_a_closer_look(const Options& options) {
  fmt::print(stderr, "recording one run under Catan and one under the default, for a closer look\n");
  for (Trial trial : looked_at(options.setting)) {
    trial.record = record_of(options.out, trial).string();
    const Result<Measured> run = run_trial(options.face_tracking(), trial);
    if (run || g_signal != 0) continue;
    static_cast<void>(fail(run.error()));
    std::error_code gone;
    std::filesystem::remove(trial.record, gone);
  }
}

// What a demonstration before left, which is not of these results.
void forget_what_was(const Options& options) {
  std::error_code not_there;
  std::filesystem::remove(std::filesystem::path(options.out) / kLookPage, not_there);
  std::filesystem::remove(options.face_tracking().faces, not_there);
  for (const Trial& trial : looked_at(options.setting)) {
    std::filesystem::remove(record_of(options.out, trial), not_there);
  }
}

Result<Results> run_all(Options& options) {
  forget_what_was(options);
  // Before minutes are spent on results that could not be kept.
  if (Status log = write_file(options.face_tracking().log, ""); !log) return log.error();

  Result<experiments::Host> host = experiments::look_at_host(options.program);
  if (!host) return host.error();
  options.setting.cpu_sets = host->cpu_sets;
  if (options.setting.quick) options.setting.cpu_sets.resize(1);
  if (!host->no_real_time.empty()) fmt::print(stderr, "Rates only: {}\n", host->no_real_time);
  if (host->cpu_sets.size() == 1) fmt::print(stderr, "One CPU: the trials on two are left out.\n");

  const Result<Compute> compute = calibrate(options);
  if (!compute) return compute.error();
  const std::vector<Trial> trials = make_trials(options.setting, *compute);
  Results results{.host = host->facts,
                  .medium_speed = options.setting.medium_speed,
                  .high_speed = options.setting.high_speed,
                  .slowdown = options.setting.slowdown,
                  .quick = options.setting.quick,
                  .no_real_time = host->no_real_time};
  Progress progress(trials.size());
  for (const Trial& trial : trials) {
    progress.begin(trial);
    Result<Measured> run = run_trial(options.face_tracking(), trial);
    if (g_signal != 0) break;
    if (!run && results.runs.empty()) return run.error();
    if (!run) {  // what was measured until now is worth keeping
      fmt::print(stderr, "\n");
      options.failed = fail(run.error());
      break;
    }
    progress.end(*run);
    results.runs.push_back(std::move(*run));
  }
  results.complete = results.runs.size() == trials.size();
  if (results.complete) take_a_closer_look(options);
  if (results.runs.empty()) return Error::environment("stopped before anything was measured", "let it run");
  return results;
}

Result<Results> load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error::caller("cannot read " + path, "name a results.json that catan_demo wrote");
  return parse_results({std::istreambuf_iterator<char>(file), {}});
}

int run(Options& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  Result<Results> results = options.from.empty() ? run_all(options) : load(options.from);
  if (!results) return fail(results.error());
  fmt::print("{}", to_text(*results));
  if (Status written = write_all(*results, options); !written) return fail(written.error());
  const std::filesystem::path out = options.out;
  fmt::print("\nPage: {}\n", (out / "report.html").string());
  if (std::filesystem::exists(out / kLookPage, error)) {
    fmt::print("Runs: {}, the same as bin/catan report {} --html --compare {}\n", (out / kLookPage).string(),
               (out / "catan.catan").string(), (out / "default.catan").string());
  }
  if (g_signal != 0) return 128 + g_signal;
  if (options.failed != 0) return options.failed;
  const Summary summary = summarise(*results);
  const bool held = std::ranges::all_of(summary.claims, &Claim::held);
  return options.check && !held ? kFailure : 0;
}

// Next to this program in the build tree, or where both were installed to.
std::string find_program() {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const auto built = (folder / "../../apps/face_tracking/face_tracking").lexically_normal();
  return std::filesystem::exists(built, error) ? built.string() : (folder / "face_tracking").string();
}

}  // namespace
}  // namespace ctn::demo

int main(int argc, char** argv) {
  using namespace ctn::demo;
  Options options;
  options.program = find_program();
  CLI::App app(
      "Shows what Catan does for a face tracking camera: runs it under the default scheduler, under Catan and "
      "at source rates set by hand, and writes a page.",
      "catan_demo");
  app.add_option("--out", options.out, "folder for report.html, results.json and the figures")->capture_default_str();
  app.add_option("--budget", options.setting.budget, "seconds that all trials together may take")
      ->check(CLI::Range(30.0, 36000.0))
      ->capture_default_str();
  app.add_option("--slowdown", options.setting.slowdown, "stand for a board that is so many times slower")
      ->check(CLI::Range(1.0, 20.0))
      ->capture_default_str();
  app.add_option("--seed", options.setting.seed, "of the face's walks")->capture_default_str();
  app.add_option("--program", options.program, "the face_tracking program")->default_str("beside this one");
  app.add_option("--from", options.from, "run nothing; make the page again from this results.json");
  app.add_flag("--quick", options.setting.quick, "a few seconds on one core, to see that it works");
  app.add_flag("--check", options.check, "exit with 1 if a claim did not hold");
  app.footer(
      "\nexit codes: 0 done, 1 it could not run (or --check), 2 a mistake, 128 + signal number when interrupted\n");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "catan_demo: {}\nSee catan_demo --help.\n", error.what());
    return kMistake;
  }
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
  return run(options);
}
