// catan plan: what Catan would do with an app on a number of cores.
#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/known_costs.h"
#include "api/plan_ahead.h"
#include "baselines/davare.h"
#include "baselines/verucchi.h"
#include "cie.h"
#include "command.h"
#include "config/app_file.h"
#include "config/quantity.h"
#include "config/ros_binding.h"
#include "explain.h"
#include "os/cpu_set.h"
#include "paper/paper.h"
#include "plan/json.h"
#include "plan/validate.h"
#include "plan_text.h"
#include "planner/expected.h"
#include "planner/explain.h"
#include "planner/planner.h"
#include "rate_plan_output.h"
#include "scheduling_options.h"
#include "status_line.h"

namespace ctn::tool {
namespace {

struct PlanOptions {
  std::string app;
  std::string costs;
  std::string slack;
  std::string planner;  // empty: as the app says
  std::optional<int> cores;
  double effort = 1.0;
  bool json = false;
  bool explain = false;
  std::string format;  // empty: text, or JSON
  std::string cpus;
  std::string groups;  // a file
};

Result<api::KnownCosts> costs_to_plan_by(const graph::App& app, const std::string& file) {
  if (!file.empty()) return api::known_costs(file, app);
  note(fmt::format(
      "no cost file: every node is taken to cost {} (scheduler.bootstrap_cost); --costs FILE gives real ones",
      config::format_duration(app.scheduler.bootstrap_cost)));
  model::Workload work(app.graph);
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    if (app.graph.nodes()[i].external) continue;
    work.set(NodeId(i), model::NodeWork::constant(to_millis(app.scheduler.bootstrap_cost)));
  }
  return api::KnownCosts{work.costs(app.graph), trial::Samples(app, work, Nanos{0}, 1)};
}

// What is to be planned, by whomever.
struct Task {
  const graph::App& app;
  const api::KnownCosts known;
  planner::ExpectedRequest request;
};

// What the request calls while it is worked on.
std::function<void(double)> shown_on(const StatusLine& line, const char* what) {
  return [&line, what](double part) { line.show(fmt::format("{}: {:.0f} %", what, 100.0 * part)); };
}

Result<plan::Plan> planned(Task& task, graph::PlannerKind by) {
  const StatusLine line;
  task.request.on_progress = shown_on(line, "planning");
  return api::plan_ahead(task.app, task.known, task.request, by);
}

planner::Explanation explained(Task& task, const plan::Plan& plan) {
  const StatusLine line;
  task.request.on_progress = shown_on(line, "planning again, with one thing changed at a time");
  return planner::explain(task.app, task.known.samples, task.known.costs, task.request, plan);
}

Result<double> slack_of(const graph::App& app, const std::string& text) {
  if (text.empty()) return app.scheduler.slack.value_or(graph::kDefaultSlack);
  return percentage_of(text, "--slack");
}

// `why` may be null.
std::string shown(const plan::Plan& plan, const graph::App& app, const planner::Explanation* why, bool json) {
  if (json) return why ? add_explanation(plan::to_json(plan, app), *why, app) : plan::to_json(plan, app);
  return plan_text(plan, app) + (why ? explain_text(*why, plan, app) : "");
}

using RateMethod = Result<baselines::RatePlan> (*)(const graph::App&, const model::CostTable&,
                                                   const baselines::RateRequest&);

// Of the methods that Catan is compared with; null: it is not one of them.
RateMethod rate_method(const std::string& name) {
  if (name == "davare") return baselines::plan_by_davare;
  if (name == "verucchi") return baselines::plan_by_verucchi;
  return nullptr;
}

// `work` runs in wall-clock time, which the plan is told.
template <class Work>
auto timed(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  auto plan = work();
  if (plan) plan->solve_time = std::chrono::steady_clock::now() - begin;
  return plan;
}

int make_rates(Task& task, RateMethod method, bool json) {
  const planner::ExpectedRequest& request = task.request;
  const auto plan = timed([&] { return method(task.app, task.known.costs, {request.cores, request.slack, 0}); });
  if (!plan) return report_error(plan.error());
  if (const auto proof = baselines::check_rates(*plan, task.app, task.known.costs, request.cores); !proof) {
    throw std::logic_error("rates that do not hold: " + proof.error().message());
  }
  const auto catans = planned(task, graph::PlannerKind::kAuto);
  const plan::Plan* beside = catans ? &*catans : nullptr;
  print(json ? rate_plan_json(*plan, task.app, beside) : rate_plan_text(*plan, task.app, beside));
  return kSuccess;
}

// The CPUs that the plan's cores are.
Result<std::vector<int>> cpus_of(const PlanOptions& options, int cores) {
  std::vector<int> cpus(static_cast<std::size_t>(cores));
  std::iota(cpus.begin(), cpus.end(), 0);
  if (options.cpus.empty()) return cpus;
  Result<os::CpuSet> chosen = os::parse_cpu_list(options.cpus);
  if (!chosen) return about_option(chosen.error(), "--cpus");
  if (chosen->size() == cpus.size()) return std::move(*chosen).cpus();
  return Error::caller(fmt::format("--cpus has {} CPUs, and the plan {} cores", chosen->size(), cores),
                       "give as many of the one as of the other: --cores N");
}

// Which callbacks the app's nodes are, and the callback groups that there are.
struct CieInput {
  std::vector<config::RosBinding> bindings;
  std::optional<CieTemplate> groups;
  std::vector<int> cpus;
};

Result<CieInput> cie_input(const PlanOptions& options, const config::AppFile& file, int cores) {
  auto bindings = config::ros_bindings(file.text, options.app, file.app);
  if (!bindings) return bindings.error();
  if (const Status fits = config::check_without_nodelets(*bindings, file.app); !fits) return fits.error();
  if (bindings->empty()) {
    return Error::caller(fmt::format("no node of app {} is a callback of a ROS program", file.app.name),
                         "write ros: {node: /mapper, topic: /scan} at its nodes (docs/ros2.md)");
  }
  if (options.planner != "auto" || file.app.scheduler.schedule == graph::ScheduleKind::kFrames) {
    return Error::caller("--format cie is of plans with fixed priorities by auto",
                         "use --planner auto, and leave schedule: frames out of the app file");
  }
  auto cpus = cpus_of(options, cores);
  if (!cpus) return cpus.error();
  CieInput input{std::move(*bindings), std::nullopt, std::move(*cpus)};
  if (options.groups.empty()) return input;
  const auto text = config::read_text(options.groups);
  if (!text) return text.error();
  auto parsed = parse_cie_template(*text, options.groups);
  if (!parsed) return parsed.error();
  input.groups = std::move(*parsed);
  return input;
}

int print_cie(const plan::Plan& plan, const graph::App& app, const CieInput& input) {
  const auto made = cie_configuration(plan, app, input.bindings, input.cpus, input.groups);
  if (!made) return report_error(made.error());
  for (const std::string& said : made->notes) note(said);
  print(made->text);
  return kSuccess;
}

int make(PlanOptions options) {
  const auto file = config::load_app_file(options.app);
  if (!file) return report_error(file.error());
  const graph::App* const loaded = &file->app;
  if (options.planner.empty()) {
    options.planner = loaded->scheduler.planner == graph::PlannerKind::kPaper ? "paper" : "auto";
  }
  if (options.explain && options.planner != "auto") {
    return report_error(Error::caller("--explain is of plans by auto", "leave out --explain, or use --planner auto"));
  }
  const bool by_paper = options.planner == "paper";
  graph::App app = by_paper ? paper::as_in_the_paper(*loaded) : *loaded;
  const int cores = options.cores.value_or(app.core_count().value_or(1));
  std::optional<CieInput> threads;
  if (options.format == "cie") {
    auto input = cie_input(options, *file, cores);
    if (!input) return report_error(input.error());
    threads = std::move(*input);
    app.scheduler.schedule = graph::ScheduleKind::kPriorities;  // threads take no turns by themselves
  }
  const auto slack = slack_of(app, options.slack);
  if (!slack) return report_error(slack.error());
  auto known = costs_to_plan_by(app, options.costs);
  if (!known) return report_error(known.error());
  Task task{
      .app = app, .known = std::move(*known), .request = {.cores = cores, .slack = *slack, .effort = options.effort}};
  if (const RateMethod rates = rate_method(options.planner)) return make_rates(task, rates, options.json);
  const auto plan =
      timed([&] { return planned(task, by_paper ? graph::PlannerKind::kPaper : graph::PlannerKind::kAuto); });
  if (!plan) return report_error(plan.error());
  if (const auto proof = plan::validate(*plan, app, task.known.costs, cores); !proof) {
    throw std::logic_error("a plan that does not hold: " + proof.error().message());
  }
  if (threads) return print_cie(*plan, app, *threads);
  std::optional<planner::Explanation> why;
  if (options.explain) why = explained(task, *plan);
  print(shown(*plan, app, why ? &*why : nullptr, options.json));
  return kSuccess;
}

}  // namespace

void add_plan_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* command = cli.add_subcommand("plan", "Plan cores, slices and rates for an app");
  command->footer(
      "Examples:\n"
      "  catan plan app.yaml --cores 4 --costs costs.yaml\n"
      "  catan plan app.yaml --cores 2 --costs costs.yaml --json > plan.json\n"
      "  catan plan app.yaml --cores 2 --costs run.catan                by what a recorded run cost\n"
      "  catan plan app.yaml --cores 2 --costs costs.yaml --explain    why, and what else could be had\n"
      "  catan plan app.yaml --slack 0%            nothing left to ordinary threads\n"
      "  catan plan robot.yaml --cores 2 --costs run.catan --format cie --template template.yaml > threads.yaml\n"
      "Exit code: 0 there is a plan, which may relax bounds and then says so, 2 a mistake, or rates that no plan "
      "keeps.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--cores", options->cores, "How many cores the app gets; else those that it lists, or 1")
      ->check(CLI::Range(1, planner::kMaxCores));
  command
      ->add_option("--costs", options->costs,
                   "Compute times (docs/cost-file.md), or a record of a run; else "
                   "scheduler.bootstrap_cost")
      ->type_name("FILE");
  command->add_option("--slack", options->slack, "Share of a core left to ordinary threads, as in 6%; else the app's")
      ->type_name("PCT");
  command
      ->add_option("--planner", options->planner,
                   "auto: as sessions plan, by what schedules come to in virtual time; paper: by formula, in fixed "
                   "frames, cores allocated before shares; or one of the methods that Catan is compared with, which "
                   "give periods and fixed priorities. Else as the app says (scheduler.planner), or auto")
      ->check(CLI::IsMember({"auto", "paper", "davare", "verucchi"}));
  command
      ->add_option("--effort", options->effort,
                   "How long to search, as a multiple of a few seconds: of --planner auto, and of what is printed "
                   "beside davare and verucchi")
      ->check(CLI::Range(api::kMinEffort, api::kMaxEffort))
      ->capture_default_str();
  CLI::Option* const json = command->add_flag("--json", options->json, "Print one JSON document");
  CLI::Option* const explain =
      command->add_flag("--explain", options->explain,
                        "Add what sets each period, what bounds cost, and how other plans differ "
                        "(docs/plan-explained.md); plans again for each, some seconds in all");
  CLI::Option* const format = command
                                  ->add_option("--format", options->format,
                                               "cie: the thread configuration that Autoware's callback-isolated "
                                               "executor for ROS 2 reads (docs/ros2.md)")
                                  ->check(CLI::IsMember({"cie"}))
                                  ->excludes(json)
                                  ->excludes(explain);
  command->add_option("--template", options->groups, "Of that configuration, as its prerun node writes it")
      ->type_name("FILE")
      ->needs(format);
  command->add_option("--cpus", options->cpus, "CPUs that the cores of that configuration are; else 0, 1, ...")
      ->type_name("LIST")
      ->needs(format);
  command->callback([options, &exit_code] { exit_code = make(*options); });
}

}  // namespace ctn::tool
