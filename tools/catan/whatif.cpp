// catan whatif: what would become of an app on other hardware, with other costs, with other weights.
#include "sim/whatif.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/policies.h"
#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "graph/change.h"
#include "os/os.h"
#include "scheduling_options.h"
#include "sim/simulation.h"
#include "whatif_output.h"

namespace ctn::tool {
namespace {

struct WhatifOptions {
  std::string app;
  std::string costs;
  std::string cores = "1-6";
  std::vector<double> speeds{0.5, 0.75, 1.0, 1.5, 2.0};
  std::vector<std::string> nodes;
  std::vector<std::string> weights;
  std::string scheduler = "catan";
  double seconds = 20.0;
  std::uint64_t seed = 1;
  std::size_t threads = 0;
  std::string svg;
  bool json = false;
};

Error mistake(const std::string& what, const std::string& hint) { return Error::caller(what, hint); }

// "NAME=0.5,1,2"
struct Values {
  std::string name;
  std::vector<double> values;
};
constexpr double kMaxValue = 1e6;

Result<Values> parse_values(const std::string& text, const char* option, double min) {
  const std::string hint = fmt::format("write {} NAME=0.5,1,2", option);
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0)
    return mistake(fmt::format("{}: '{}' has no values", option, text), hint);
  Values values{text.substr(0, equals), {}};
  std::string rest = text.substr(equals + 1) + ",";
  for (std::size_t comma = rest.find(','); comma != std::string::npos; comma = rest.find(',')) {
    const std::string item = rest.substr(0, comma);
    rest.erase(0, comma + 1);
    char* end = nullptr;
    const double value = std::strtod(item.c_str(), &end);
    if (item.empty() || *end != '\0' || !(value >= min) || value > kMaxValue) {
      return mistake(fmt::format("{}: '{}' is not a number from {} to {}", option, item, min, kMaxValue), hint);
    }
    values.values.push_back(value);
  }
  return values;
}

Result<std::vector<int>> parse_cores(const std::string& text) {
  const auto counts = os::parse_cpu_list(text);
  if (!counts || counts->empty() || counts->cpus().front() < 1 || counts->cpus().back() > sim::kMaxCores) {
    return mistake(fmt::format("--cores: '{}' are not numbers of cores", text), "write --cores 1-6, or 1,2,4");
  }
  return counts->cpus();
}

Result<std::vector<sim::Hypothesis>> of_nodes(const WhatifOptions& options, const graph::App& app, int cores) {
  std::vector<sim::Hypothesis> asked;
  for (const std::string& text : options.nodes) {
    const auto values = parse_values(text, "--node", 1e-3);
    if (!values) return values.error();
    const auto node = app.graph.find_node(values->name);
    if (!node || app.graph.node(*node).external) {
      return mistake(fmt::format("--node: the app has no node '{}' that costs anything", values->name),
                     "name one of its nodes");
    }
    for (const double factor : values->values) asked.push_back({.cores = cores, .node = *node, .factor = factor});
  }
  return asked;
}

Result<std::vector<sim::Hypothesis>> of_weights(const WhatifOptions& options, const graph::App& app, int cores) {
  std::vector<sim::Hypothesis> asked;
  for (const std::string& text : options.weights) {
    const auto values = parse_values(text, "--weight", 0.0);
    if (!values) return values.error();
    const auto term = graph::find_term(app, values->name);
    if (!term) return about_option(term.error(), "--weight");
    for (const double weight : values->values) asked.push_back({.cores = cores, .term = *term, .weight = weight});
  }
  return asked;
}

// Overwritten in place, on a terminal only: scripts that keep stderr have no use for it.
void show_progress(std::size_t done, std::size_t all) {
  if (isatty(STDERR_FILENO) == 0) return;
  print_on_stderr(fmt::format("\r{} of {} answered{}", done, all, done == all ? "\r\x1b[K" : ""));
}

int ask(const WhatifOptions& options) {
  const auto app = config::load_app(options.app);
  if (!app) return report_error(app.error());
  const auto work = config::load_workload(options.costs, *app);
  if (!work) return report_error(work.error());
  const auto policy = api::simulated_policy(options.scheduler, *app);
  if (!policy) return report_error(policy.error());
  const auto cores = parse_cores(options.cores);
  if (!cores) return report_error(cores.error());
  const auto nodes = of_nodes(options, *app, cores->front());
  if (!nodes) return report_error(nodes.error());
  const auto weights = of_weights(options, *app, cores->front());
  if (!weights) return report_error(weights.error());

  WhatIf result{.app = *app, .scheduler = options.scheduler, .seconds = options.seconds, .seed = options.seed};
  std::vector<sim::Hypothesis> asked;
  const std::set<double> speeds(options.speeds.begin(), options.speeds.end());
  for (const int count : *cores) {
    for (const double speed : speeds) asked.push_back({.cores = count, .speed = speed});
  }
  const std::size_t hardware = asked.size();
  asked.insert(asked.end(), nodes->begin(), nodes->end());
  const std::size_t until_weights = asked.size();
  asked.insert(asked.end(), weights->begin(), weights->end());

  std::set<NodeId> varied;
  for (const sim::Hypothesis& each : *nodes) varied.insert(*each.node);
  const bool limited = policy->policy->follows_plan() && app->has_bounds();
  const std::size_t all = asked.size() + (limited ? cores->size() + varied.size() : 0);
  auto answers = sim::answer(*app, *work, asked,
                             {.policy = policy->policy,
                              .reserve = policy->reserve,
                              .seconds = options.seconds,
                              .seed = options.seed,
                              .threads = options.threads,
                              .on_progress = [&](std::size_t done) { show_progress(done, all); }});
  if (!answers) return report_error(answers.error());
  const auto at = [&](std::size_t index) { return answers->begin() + static_cast<std::ptrdiff_t>(index); };
  result.hardware.assign(at(0), at(hardware));
  result.nodes.assign(at(hardware), at(until_weights));
  result.weights.assign(at(until_weights), answers->end());
  if (limited) {
    std::size_t done = asked.size();
    for (const int count : *cores) {
      result.limits.push_back({count, sim::min_speed(*app, *work, count)});
      show_progress(++done, all);
    }
    for (const NodeId node : varied) {
      result.node_limits.push_back({node, sim::max_factor(*app, *work, {.cores = cores->front()}, node)});
      show_progress(++done, all);
    }
  }
  if (!options.svg.empty()) {
    const auto drawing = whatif_svg(result);
    if (!drawing) return report_error(drawing.error());
    std::ofstream file(options.svg);
    file << *drawing;
    if (!file.flush()) {
      return report_error(
          Error::environment(fmt::format("cannot write {}", options.svg), "name a file in a folder that is there"));
    }
  }
  print(options.json ? whatif_json(result) : whatif_text(result));
  return kSuccess;
}

}  // namespace

void add_whatif_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<WhatifOptions>();
  CLI::App* command =
      cli.add_subcommand("whatif", "What would become of an app on other hardware, with other costs or weights");
  command->footer(
      "Examples:\n"
      "  catan whatif app.yaml --costs costs.yaml                                1 to 6 cores, five speeds\n"
      "  catan whatif app.yaml --costs costs.yaml --cores 1,2 --speeds 1 --node detect=1,2,4\n"
      "  catan whatif app.yaml --costs costs.yaml --cores 1 --speeds 1 --weight 0=0.5,1,2\n"
      "  catan whatif app.yaml --costs costs.yaml --svg whatif.svg --json\n"
      "Each case is planned (promised, at worst) and simulated. docs/simulation.md says how close that is to life.\n"
      "Exit code: 0 all cases were tried, 1 failure at run time, 2 a mistake in a file or on the command line.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--costs", options->costs, "Compute times and how they vary (docs/cost-file.md)")
      ->type_name("FILE")
      ->required();
  command->add_option("--cores", options->cores, "Numbers of cores, as 1-6 or 1,2,4")
      ->type_name("LIST")
      ->capture_default_str();
  command->add_option("--speeds", options->speeds, "Speeds of the cores: at 2 everything takes half as long")
      ->delimiter(',')
      ->check(within(1e-3, 1e3))
      ->capture_default_str();
  command->add_option("--node", options->nodes, "One node's costs times these, on the first of --cores at speed 1")
      ->type_name("NODE=LIST");
  command
      ->add_option(
          "--weight", options->weights,
          "These weights for a term of the objective, by number (0 is the first) or path, on the first of --cores")
      ->type_name("TERM=LIST");
  command->add_option("--scheduler", options->scheduler, "As catan sim has them")->capture_default_str();
  command->add_option("--seconds", options->seconds, "How long each case is measured, of simulated time")
      ->check(within(0.1, 1e6))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Of the draws")->check(CLI::NonNegativeNumber)->capture_default_str();
  command->add_option("--threads", options->threads, "Else as many as there are CPUs")->check(CLI::Range(1, 1024));
  command->add_option("--svg", options->svg, "Draws response times over speed into this file, too")->type_name("FILE");
  command->add_flag("--json", options->json, "Print one JSON document");
  command->callback([options, &exit_code] { exit_code = ask(*options); });
}

}  // namespace ctn::tool
