// catan node: a program that plays nodes of an app that is served, with a synthetic load.
#include <fmt/format.h>

#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "base/text.h"
#include "catan/client.h"
#include "command.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "os/linux/linux_os.h"
#include "os/linux/poller.h"
#include "os/linux/signal_watch.h"
#include "synthetic.h"

namespace ctn::tool {
namespace {

struct NodeOptions {
  std::string app;
  std::vector<std::string> nodes;
  std::string synthetic;
  std::string socket;
  std::uint64_t seed = 1;
};

Result<std::vector<NodeId>> find_nodes(const graph::App& app, const std::vector<std::string>& names) {
  std::vector<NodeId> nodes;
  std::vector<Problem> problems;
  for (const std::string& name : names) {
    const auto node = app.graph.find_node(name);
    if (node && !app.graph.node(*node).external) {
      nodes.push_back(*node);
    } else {
      problems.push_back({{},
                          {},
                          fmt::format("app {} has no node {} of its own", app.name, quote(name)),
                          "use a name from its nodes section that is not external"});
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return nodes;
}

Status wait_for_signal(os::SignalWatch& signals) {
  const auto poller = os::Poller::make();
  if (!poller) return poller.error();
  if (Status added = (*poller)->add(signals.descriptor(), 1); !added) return added;
  while (!signals.next()) (*poller)->wait(kNever);
  return Done{};
}

Status play(const NodeOptions& options) {
  outlive_readers();
  const auto app = config::load_app(options.app);
  if (!app) return app.error();
  auto work = config::load_workload(options.synthetic, *app);
  if (!work) return work.error();
  const auto nodes = find_nodes(*app, options.nodes);
  if (!nodes) return nodes.error();
  auto signals = os::SignalWatch::start({SIGINT, SIGTERM, SIGHUP});
  if (!signals) return signals.error();

  const std::unique_ptr<os::Os> os = os::make_linux_os();
  SyntheticLoad load(*app, std::move(*work), options.seed, *os);
  ClientOptions connection;
  connection.socket = options.socket;
  connection.app = app->name;
  connection.on_notice = [](const std::string& text) { note(text); };
  auto client = Client::connect(connection);
  if (!client) return client.error();
  load.attach(*client, *nodes);
  load.begin();
  if (Status started = client->start(); !started) return started;
  if (Status added = load.add_threads(*client); !added) return added;
  if (Status waited = wait_for_signal(*signals); !waited) return waited;
  load.stop();
  client->stop();
  return Done{};
}

}  // namespace

void add_node_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<NodeOptions>();
  CLI::App* command = cli.add_subcommand("node", "Play nodes of a served app with a synthetic load");
  command->footer(
      "Examples:\n"
      "  catan node app.yaml camera --synthetic costs.yaml               until Ctrl-C or SIGTERM\n"
      "  catan node app.yaml detect plan --synthetic costs.yaml --socket /tmp/app.sock\n"
      "catan run APP --synthetic COSTS --processes starts one for each subchain.\n"
      "Exit code: 0 it was told to end, 1 no server answers, or it refuses, 2 a mistake.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("NODE", options->nodes, "Nodes to play, all in this process")->required();
  command->add_option("--synthetic", options->synthetic, "Burn CPU time as this cost file says (docs/cost-file.md)")
      ->type_name("COSTS")
      ->required();
  command->add_option("--socket", options->socket, "Of the server; else CATAN_SOCKET, else the app's usual one")
      ->type_name("PATH");
  command->add_option("--seed", options->seed, "Of the draws: equal seeds, equal draws")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->callback([options, &exit_code] {
    const Status played = play(*options);
    exit_code = played ? kSuccess : report_error(played.error());
  });
}

}  // namespace ctn::tool
