// catan plan: what Catan would do with an app on a number of cores.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

#include "baselines/davare.h"
#include "baselines/verucchi.h"
#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "config/quantity.h"
#include "explain.h"
#include "paper/paper.h"
#include "plan/json.h"
#include "plan/validate.h"
#include "plan_text.h"
#include "planner/expected.h"
#include "planner/explain.h"
#include "planner/planner.h"
#include "rate_plan_output.h"
#include "scheduling_options.h"

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
};

Result<model::Workload> work_of(const graph::App& app, const std::string& file) {
  if (!file.empty()) return config::load_workload(file, app);
  note(fmt::format(
      "no cost file: every node is taken to cost {} (scheduler.bootstrap_cost); --costs FILE gives real ones",
      config::format_duration(app.scheduler.bootstrap_cost)));
  model::Workload work(app.graph);
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    if (app.graph.nodes()[i].external) continue;
    work.set(NodeId(i), model::NodeWork::constant(to_millis(app.scheduler.bootstrap_cost)));
  }
  return work;
}

// The app, as the planner takes it.
graph::App as_planned_by(const std::string& planner, const graph::App& app) {
  return planner == "paper" ? paper::as_in_the_paper(app) : app;
}

// How long the search is, as a multiple of a few seconds.
constexpr double kLeastEffort = 0.001;
constexpr double kMostEffort = 1000.0;

Result<plan::Plan> planned(const graph::App& app, const model::Workload& work, const model::CostTable& costs,
                           const planner::Request& request, const PlanOptions& options) {
  if (options.planner == "paper") return paper::make_plan(app, costs, {.cores = request.cores, .slack = request.slack});
  if (options.planner != "auto") return planner::make_plan(app, costs, request);
  const trial::Samples samples(app, work, Nanos{0}, 1);
  return planner::make_expected_plan(app, samples, costs,
                                     {.cores = request.cores, .slack = request.slack, .effort = options.effort});
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

int make_rates(const graph::App& app, const model::CostTable& costs, const planner::Request& request, RateMethod method,
               bool json) {
  const auto begin = std::chrono::steady_clock::now();
  auto plan = method(app, costs, {request.cores, request.slack, 0});
  if (!plan) return report_error(plan.error());
  plan->solve_time = std::chrono::steady_clock::now() - begin;
  if (const auto proof = baselines::check_rates(*plan, app, costs, request.cores); !proof) {
    throw std::logic_error("rates that do not hold: " + proof.error().message());
  }
  const auto catans = planner::make_plan(app, costs, request);
  const plan::Plan* beside = catans ? &*catans : nullptr;
  print(json ? rate_plan_json(*plan, app, beside) : rate_plan_text(*plan, app, beside));
  return kSuccess;
}

int make(PlanOptions options) {
  const auto loaded = config::load_app(options.app);
  if (!loaded) return report_error(loaded.error());
  if (options.planner.empty()) {
    options.planner = loaded->scheduler.planner == graph::PlannerKind::kPaper ? "paper" : "joint";
  }
  const std::optional<graph::App> app = as_planned_by(options.planner, *loaded);
  const auto slack = slack_of(*app, options.slack);
  if (!slack) return report_error(slack.error());
  const auto work = work_of(*app, options.costs);
  if (!work) return report_error(work.error());
  const model::CostTable costs = work->costs(app->graph);
  const planner::Request request{.cores = options.cores.value_or(app->core_count().value_or(1)), .slack = *slack};
  if (const RateMethod rates = rate_method(options.planner)) {
    if (options.explain) {
      return report_error(Error::caller("--explain is of Catan's own plans", "leave out --explain or --planner"));
    }
    return make_rates(*app, costs, request, rates, options.json);
  }
  const auto begin = std::chrono::steady_clock::now();
  if (options.explain && options.planner != "joint") {
    return report_error(Error::caller("--explain is of plans by joint", "leave out --explain, or use --planner joint"));
  }
  auto plan = planned(*app, *work, costs, request, options);
  if (!plan) return report_error(plan.error());
  plan->solve_time = std::chrono::steady_clock::now() - begin;
  if (const auto proof = plan::validate(*plan, *app, costs, request.cores); !proof) {
    throw std::logic_error("a plan that does not hold: " + proof.error().message());
  }
  std::optional<planner::Explanation> why;
  if (options.explain) why = planner::explain(*app, costs, request, *plan);
  print(shown(*plan, *app, why ? &*why : nullptr, options.json));
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
      "  catan plan app.yaml --cores 2 --costs costs.yaml --explain    why, and what else could be had\n"
      "  catan plan app.yaml --slack 0%            nothing left to ordinary threads");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--cores", options->cores, "How many cores the app gets; else those that it lists, or 1")
      ->check(CLI::Range(1, planner::kMaxCores));
  command->add_option("--costs", options->costs, "Compute times (docs/cost-file.md); else scheduler.bootstrap_cost")
      ->type_name("FILE");
  command->add_option("--slack", options->slack, "Share of a core left to ordinary threads, as in 6%; else the app's")
      ->type_name("PCT");
  command
      ->add_option("--planner", options->planner,
                   "joint, paper: by formula, cores allocated jointly with the shares, or before them as if shares "
                   "were equal, as "
                   "in the paper; auto: by what schedules come to in virtual time, of frames and of fixed priorities; "
                   "or one of the "
                   "methods that Catan is compared with, which give periods and fixed priorities. Else as the app says "
                   "(scheduler.planner), or joint")
      ->check(CLI::IsMember({"joint", "paper", "auto", "davare", "verucchi"}));
  command
      ->add_option("--effort", options->effort, "Of --planner auto: how long to search, as a multiple of a few seconds")
      ->check(CLI::Range(kLeastEffort, kMostEffort))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON document");
  command->add_flag("--explain", options->explain,
                    "Add what binds each period, what bounds cost, and how other plans differ "
                    "(docs/plan-explained.md); plans many times over");
  command->callback([options, &exit_code] { exit_code = make(*options); });
}

}  // namespace ctn::tool
