// catan sim: what an app would come to, in virtual time.
#include <fmt/format.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "api/known_costs.h"
#include "api/policies.h"
#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "record/reader.h"
#include "scheduling_options.h"
#include "sim/batch.h"
#include "sim/json.h"
#include "sim/recorded_costs.h"
#include "sim/simulation.h"
#include "sim_sweep.h"
#include "sim_text.h"
#include "sim_validate.h"
#include "status_line.h"

namespace ctn::tool {
namespace {

struct SimOptions {
  std::string app;
  std::string costs;
  std::string scheduler = "catan";
  std::optional<int> cores;
  double seconds = 60.0;
  std::uint64_t seed = 1;
  int runs = 1;
  std::size_t threads = 0;
  std::string frames;
  bool no_stealing = false;
  bool no_replan = false;
  std::string slack;
  std::string background;
  bool resample = false;
  bool ideal = false;
  double drift = 0.0;
  std::string validated;  // record to be compared with
  std::string record;     // to be written
  std::string folder;     // of apps
  std::string out;
  bool json = false;
};

void add_background(double part, sim::Machine& machine) {
  constexpr Nanos kPeriod = std::chrono::milliseconds{10};
  for (int core = 0; part > 0.0 && core < machine.cores; ++core) {
    machine.background.push_back({core, to_nanos(part * to_millis(kPeriod)), kPeriod});
  }
}

Result<sim::Options> simulation_options(const SimOptions& options, const graph::App& app) {
  auto policy = api::simulated_policy(options.scheduler, app);
  if (!policy) return policy.error();
  sim::Options chosen;
  chosen.policy = std::move(policy->policy);
  chosen.reserve = std::move(policy->reserve);
  chosen.machine.cores = options.cores.value_or(app.core_count().value_or(1));
  if (options.ideal) chosen.machine.costs = sim::MachineCosts::none();
  chosen.stealing = !options.no_stealing;
  chosen.replan = !options.no_replan;
  chosen.frames = frame_mode(options.frames);
  if (!options.slack.empty()) {
    const auto slack = percentage_of(options.slack, "--slack");
    if (!slack) return slack.error();
    chosen.slack = *slack;
  }
  if (!options.background.empty()) {
    const auto part = percentage_of(options.background, "--background");
    if (!part) return part.error();
    add_background(*part, chosen.machine);
  }
  return chosen;
}

struct Costs {
  std::function<std::unique_ptr<sim::RunCosts>(std::uint64_t seed)> make;
  std::optional<model::CostTable> known;  // what is planned with; none of a record
};

// From a cost file, or from the record of a run. `app` outlives what it makes.
Result<Costs> costs_of(const graph::App& app, const std::string& file, bool resample, Nanos overhead) {
  if (!record::looks_like_record(file)) {
    auto work = config::load_workload(file, app);
    if (!work) return work.error();
    model::CostTable known = work->costs(app.graph);
    return Costs{[&app, work = std::move(*work)](std::uint64_t seed) {
                   return std::make_unique<sim::DrawnCosts>(app, work, seed);
                 },
                 std::move(known)};
  }
  const auto record = record::Reader::open(file);
  if (!record) return record.error();
  auto read = sim::RecordedRuns::read(*record, app);
  if (!read) return read.error();
  using Order = sim::RecordedCosts::Order;
  const Order order = resample ? Order::kDrawn : Order::kAsRecorded;
  const auto runs = std::make_shared<const sim::RecordedRuns>(std::move(*read));
  return Costs{[&app, runs, order, overhead](std::uint64_t seed) {
                 return std::make_unique<sim::RecordedCosts>(app, runs, order, seed, overhead);
               },
               std::nullopt};
}

struct Simulated {
  std::vector<sim::Seeded> runs;
  int cores = 1;
};

// Tells which part of several runs is done, when a part of one of them is: one call at a time. From any thread.
class MeanPart {
 public:
  // `tell` may be empty.
  MeanPart(std::size_t runs, std::function<void(double)> tell) : tell_(std::move(tell)), parts_(runs) {}

  void set(std::size_t run, double part) {
    if (!tell_) return;
    const std::lock_guard lock(mutex_);
    parts_[run] = part;
    tell_(std::accumulate(parts_.begin(), parts_.end(), 0.0) / static_cast<double>(parts_.size()));
  }

 private:
  const std::function<void(double)> tell_;
  std::mutex mutex_;  // guards `parts_`
  std::vector<double> parts_;
};

// All runs of one app, on so many threads. `on_progress`: is called from any of them, one at a time.
Result<Simulated> simulate_app(const SimOptions& options, const std::string& app_file, const std::string& cost_file,
                               std::size_t threads, const std::function<void(double)>& on_progress = {}) {
  const auto app = config::load_app(app_file);
  if (!app) return app.error();
  auto chosen = simulation_options(options, *app);
  if (!chosen) return chosen.error();
  const auto costs = costs_of(*app, cost_file, options.resample, chosen->machine.costs.mean_run());
  if (!costs) return costs.error();
  chosen->costs = costs->known;
  if (!options.record.empty()) {
    chosen->recording = {options.record,
                         fmt::format("simulated with the costs of {}, seed {}", cost_file, options.seed)};
  }

  std::vector<std::optional<Result<sim::Outcome>>> outcomes(static_cast<std::size_t>(options.runs));
  MeanPart done(outcomes.size(), on_progress);
  sim::for_each_in_parallel(outcomes.size(), threads, [&](std::size_t index) {
    sim::Options of_run = *chosen;
    of_run.clocks = {.seed = options.seed + index, .drift_ppm = options.drift};
    outcomes[index] =
        sim::simulate(*app, costs->make(options.seed + index), std::move(of_run),
                      to_nanos(Millis{options.seconds * 1000.0}), [&](double part) { done.set(index, part); });
    done.set(index, 1.0);
  });
  Simulated simulated{.runs = {}, .cores = chosen->machine.cores};
  for (std::size_t index = 0; index < outcomes.size(); ++index) {
    if (!*outcomes[index]) return outcomes[index]->error();
    simulated.runs.push_back({options.seed + index, std::move(**outcomes[index])});
  }
  return simulated;
}

int simulate_all(const SimOptions& options) {
  ProgressLine progress("simulated");
  const auto simulated = simulate_app(options, options.app, options.costs, options.threads,
                                      [&progress](double part) { progress.show(part); });
  progress.end();
  if (!simulated) return report_error(simulated.error());
  const auto& [runs, cores] = *simulated;
  print(options.json ? sim::to_json(runs, cores) : sim_text(runs, cores));
  return kSuccess;
}

// What came out of a sweep depends on this and on the files alone.
std::string asked_of(const SimOptions& options) {
  nlohmann::ordered_json asked{{"scheduler", options.scheduler},
                               {"cores", nullptr},
                               {"seconds", options.seconds},
                               {"seed", options.seed},
                               {"runs", options.runs},
                               {"frames", options.frames},
                               {"stealing", !options.no_stealing},
                               {"replan", !options.no_replan},
                               {"slack", options.slack},
                               {"background", options.background},
                               {"resample", options.resample},
                               {"ideal", options.ideal}};
  if (options.cores) asked["cores"] = *options.cores;
  if (options.drift > 0.0) asked["drift"] = options.drift;
  return nlohmann::ordered_json{{"sweep", asked}}.dump();
}

int sweep_all(const SimOptions& options) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto swept = sweep({.folder = options.folder,
                            .out = options.out,
                            .asked = asked_of(options),
                            .threads = options.threads,
                            .simulate = [&](const std::string& app, const std::string& costs) -> Result<std::string> {
                              const auto simulated = simulate_app(options, app, costs, 1);
                              if (!simulated) return simulated.error();
                              return sim::to_json(simulated->runs, simulated->cores);
                            },
                            .on_progress =
                                [&](std::size_t done, std::size_t all) {
                                  if (!terminal) return;
                                  print_on_stderr(fmt::format("\r{} of {} apps{}", done, all, done == all ? "\n" : ""));
                                }});
  if (!swept) return report_error(swept.error());
  note(fmt::format("{} apps in {}: {} were there, {} could not be simulated", swept->apps, options.out,
                   swept->found_done, swept->failed));
  return swept->failed == 0 ? kSuccess : kFailure;
}

int validate(const SimOptions& options) {
  ProgressLine progress("simulated");
  const auto validation = validate_against(options.validated, [&progress](double part) { progress.show(part); });
  progress.end();
  if (!validation) return report_error(validation.error());
  print(options.json ? validation->json : validation->text);
  return kSuccess;
}

int run(const SimOptions& options) {
  if (!options.validated.empty()) return validate(options);
  if (!options.folder.empty()) {
    if (!options.out.empty()) return sweep_all(options);
    return report_error(Error::caller("--sweep has nowhere to write", "add --out FILE.jsonl"));
  }
  if (options.app.empty() || options.costs.empty()) {
    return report_error(
        Error::caller("no app or no costs to simulate", "write catan sim APP --costs FILE, or --validate RECORD"));
  }
  if (options.resample && !record::looks_like_record(options.costs)) {
    return report_error(Error::caller("--resample draws from the runs of a record, and --costs is none",
                                      "leave it out: costs of a cost file are drawn already"));
  }
  if (!options.record.empty() && options.runs > 1) {
    return report_error(Error::caller("a record is of one run", "leave --runs out, or --record"));
  }
  return simulate_all(options);
}

}  // namespace

void add_sim_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<SimOptions>();
  CLI::App* command = cli.add_subcommand("sim", "Simulate an app in virtual time and show what it came to");
  command->footer(
      "Examples:\n"
      "  catan sim app.yaml --costs costs.yaml --cores 2\n"
      "  catan sim app.yaml --costs costs.yaml --cores 2 --scheduler default     to compare with\n"
      "  catan sim app.yaml --costs costs.yaml --cores 4 --runs 20               20 seeds, on all CPUs\n"
      "  catan sim app.yaml --costs costs.yaml --scheduler static:plan.json --json\n"
      "  catan sim app.yaml --costs run.catan                                    the costs of a real run\n"
      "  catan sim --validate run.catan                                          how far a simulation is from it\n"
      "  catan sim app.yaml --costs costs.yaml --record sim.catan                then: catan report sim.catan\n"
      "  catan sim --sweep apps/ --out results.jsonl --cores 2                   many apps; stopped, it goes on\n"
      "The same command gives the same bytes on every machine. docs/simulation.md says what is modelled and how close\n"
      "to life it is, docs/sim-schema.md what --json prints.\n"
      "Exit code: 0 it was simulated, 1 failure at run time, 2 a mistake in a file or on the command line.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)");
  command
      ->add_option("--costs", options->costs,
                   "Compute times and how they vary (docs/cost-file.md), or the record of a run, whose runs cost the "
                   "same again")
      ->type_name("FILE");
  command->add_option("--cores", options->cores, "How many cores the app gets; else those that it lists, or 1")
      ->check(CLI::Range(1, sim::kMaxCores));
  command
      ->add_option(
          "--scheduler", options->scheduler,
          "As catan run has them: catan, auto, paper, default, fifo, rate:HZ, static:PLAN.json, rates-of:PLAN.json; "
          "picas, deadline, davare, verucchi, each by --costs or, as in picas:COSTS.yaml, by a file of its own")
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "How long to measure, after the warm-up; of simulated time")
      ->check(within(0.1, 8'640'000.0))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Of the draws; of several runs the first's")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--runs", options->runs, "So many runs, each with a seed one higher")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  command->add_option("--threads", options->threads, "For several runs: else as many as there are CPUs")
      ->check(CLI::Range(1, 1024));
  command->add_option("--frames", options->frames, "Frames of shared cores; else as the app says")
      ->check(CLI::IsMember({"elastic", "fixed"}));
  command->add_flag("--no-stealing", options->no_stealing, "No unfinished subchain goes on in another's slot");
  command->add_flag("--no-replan", options->no_replan, "Keep the first plan that rests on measured times");
  command->add_option("--slack", options->slack, "Share of a core left to ordinary threads, as in 6%; else the app's")
      ->type_name("PCT");
  command
      ->add_option("--background", options->background,
                   "On each core an ordinary thread of another program that would use so much of it, as in 50%")
      ->type_name("PCT");
  command->add_flag("--resample", options->resample,
                    "With a record: each run costs what one of the node's did, drawn at random from the seed");
  command->add_flag("--ideal", options->ideal, "A machine on which scheduling costs nothing");
  command->add_option("--validate", options->validated, "Simulate what a record ran, and show how far off that is")
      ->type_name("RECORD")
      ->excludes("APP", "--costs", "--scheduler", "--cores", "--seconds", "--seed", "--runs", "--threads", "--frames",
                 "--no-stealing", "--no-replan", "--slack", "--background", "--resample", "--ideal");
  command->add_option("--sweep", options->folder, "Simulate every app of a folder: NAME.yaml with NAME.costs.yaml")
      ->type_name("FOLDER")
      ->excludes("APP", "--costs", "--validate");
  command->add_option("--out", options->out, "Of a sweep: a JSON document a line; a file that is there is gone on with")
      ->type_name("FILE")
      ->needs("--sweep");
  command
      ->add_option("--record", options->record,
                   "Write a record of the run to FILE, as catan run does, for catan report and for SQL")
      ->type_name("FILE")
      ->excludes("--validate", "--sweep");
  command
      ->add_option("--drift", options->drift,
                   "Clocks that are not Catan's (of external and unscheduled nodes) have any phase, and are up to so "
                   "many parts of a million fast or slow; quartz: 20 to 100")
      ->type_name("PPM")
      ->check(within(0.0, 100'000.0))
      ->excludes("--validate");
  command->add_flag("--json", options->json, "Print one JSON document");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace ctn::tool
