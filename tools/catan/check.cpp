// catan check: is the app file right, and does it say what was meant?
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "describe.h"

namespace ctn::tool {
namespace {

struct CheckOptions {
  std::string app;
  std::string costs;
  bool json = false;
  bool dot = false;
};

int check(const CheckOptions& options) {
  const auto app = config::load_app(options.app);
  if (!app) return report_error(app.error());
  std::optional<model::CostTable> costs;
  if (!options.costs.empty()) {
    auto loaded = config::load_costs(options.costs, *app);
    if (!loaded) return report_error(loaded.error());
    costs = std::move(*loaded);
  }
  const auto describe = options.json ? describe_json : options.dot ? describe_dot : describe_text;
  print(describe(*app, costs ? &*costs : nullptr));
  return kSuccess;
}

}  // namespace

void add_check_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = cli.add_subcommand("check", "Check an app file and show the app as Catan understood it");
  command->footer(
      "Examples:\n"
      "  catan check app.yaml                      nodes, triggers, objective\n"
      "  catan check app.yaml --costs costs.yaml   the cost file too\n"
      "  catan check app.yaml --dot | dot -Tsvg > app.svg\n"
      "Exit code: 0 the files are right, 2 a mistake in one of them or on the command line.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--costs", options->costs, "Cost file to check with it (docs/cost-file.md)")->type_name("FILE");
  CLI::Option* json = command->add_flag("--json", options->json, "Print one JSON document");
  command->add_flag("--dot", options->dot, "Print the graph for Graphviz")->excludes(json);
  command->callback([options, &exit_code] { exit_code = check(*options); });
}

}  // namespace ctn::tool
