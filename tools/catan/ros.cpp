// catan ros: schedules ROS programs that nobody changed.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "base/text.h"
#include "command.h"
#include "common/binding.h"
#include "config/app_file.h"
#include "config/ros_binding.h"
#include "ros_bind.h"
#include "ros_libraries.h"
#include "ros_node.h"
#include "runtime/socket_path.h"
#include "scheduling_options.h"
#include "serving_programs.h"
#include "temporary_folder.h"
#include "watch.h"

namespace ctn::tool {
namespace {

// After which a node that is bound should have run.
constexpr double kAllShouldRun = 10.0;

struct RosRunOptions {
  std::string app;
  std::string bind;
  std::string socket;
  std::vector<std::string> command;
  SchedulingOptions scheduling;
  WatchedApp watched;
  std::optional<double> seconds;
  bool json = false;
};

// --- What programs are told ---

catan_ros::Binding::Kind kind_of(config::RosCallback::Kind kind) {
  switch (kind) {
    case config::RosCallback::Kind::kTopic:
      return catan_ros::Binding::Kind::kTopic;
    case config::RosCallback::Kind::kTimer:
      return catan_ros::Binding::Kind::kTimer;
    case config::RosCallback::Kind::kService:
      break;
  }
  return catan_ros::Binding::Kind::kService;
}

// What the successors of a node take from topics, if all of them do; else nothing: then whatever it publishes counts.
std::vector<std::string> output_topics(const graph::Graph& graph, NodeId node,
                                       const std::vector<config::RosBinding>& bindings) {
  std::vector<std::string> topics;
  for (const NodeId successor : graph.node(node).successors) {
    const auto bound = std::find_if(bindings.begin(), bindings.end(),
                                    [&](const config::RosBinding& binding) { return binding.node == successor; });
    if (bound == bindings.end() || bound->callback.kind != config::RosCallback::Kind::kTopic) return {};
    topics.push_back(bound->callback.name);
  }
  return topics;
}

// Whether all that take its data are callbacks of the same ROS node.
bool feeds_own_program(const graph::Graph& graph, const config::RosBinding& binding,
                       const std::vector<config::RosBinding>& bindings) {
  const std::vector<NodeId>& successors = graph.node(binding.node).successors;
  return !successors.empty() && std::all_of(successors.begin(), successors.end(), [&](NodeId successor) {
    return std::any_of(bindings.begin(), bindings.end(), [&](const config::RosBinding& other) {
      return other.node == successor && other.callback.node == binding.callback.node;
    });
  });
}

std::vector<catan_ros::Binding> told_bindings(const graph::Graph& graph,
                                              const std::vector<config::RosBinding>& bindings) {
  std::vector<catan_ros::Binding> told;
  for (const config::RosBinding& binding : bindings) {
    const graph::Node& node = graph.node(binding.node);
    catan_ros::Binding one;
    one.node = node.name;
    one.ros_node = binding.callback.node;
    one.kind = kind_of(binding.callback.kind);
    one.name = binding.callback.name;
    one.period = binding.callback.period;
    one.takes_all = node.input == graph::InputKind::kQueue;
    one.runs_by_itself = node.unscheduled && !node.follows;
    one.always_gives_output = std::all_of(node.successors.begin(), node.successors.end(),
                                          [&](NodeId successor) { return graph.node(successor).external; });
    one.feeds_own_program = feeds_own_program(graph, binding, bindings);
    for (const NodeId predecessor : node.predecessors) {
      if (!graph.node(predecessor).external) one.predecessors.push_back(graph.node(predecessor).name);
    }
    one.output_topics = output_topics(graph, binding.node, bindings);
    told.push_back(std::move(one));
  }
  return told;
}

Result<std::vector<config::RosBinding>> load_bindings(const config::AppFile& file, const RosRunOptions& options) {
  const auto bindings = [&]() -> Result<std::vector<config::RosBinding>> {
    if (options.bind.empty()) return config::ros_bindings(file.text, options.app, file.app);
    const auto text = config::read_text(options.bind);
    if (!text) return text.error();
    return config::ros_bindings(file.text, options.app, file.app, *text, options.bind);
  }();
  if (bindings && bindings->empty()) {
    return Error::caller(fmt::format("no node of app {} is a callback of a ROS program", file.app.name),
                         "write ros: {node: /mapper, topic: /scan} at its nodes, or give a file with --bind "
                         "(docs/ros1.md)");
  }
  return bindings;
}

// --- What is loaded into them ---

// `socket` is where the server listens; the file of messages lies beside it.
Result<std::vector<std::string>> environment_of(const graph::Graph& graph,
                                                const std::vector<config::RosBinding>& bindings,
                                                const std::string& socket) {
  auto preload = ros_preload_entry();
  if (!preload) return preload.error();
  return std::vector<std::string>{
      std::move(*preload),
      fmt::format("{}={}", catan_ros::kBindingsVariable, catan_ros::to_text(told_bindings(graph, bindings))),
      fmt::format("{}={}.messages", catan_ros::kMessageRunsVariable, std::filesystem::absolute(socket).string())};
}

// --- Running ---

// Tells, once, which bound nodes have not run when all should have.
class Missing {
 public:
  Missing(const graph::Graph& graph, std::vector<config::RosBinding> bindings)
      : graph_(graph), bindings_(std::move(bindings)) {}

  // Twice a second.
  void look(const Snapshot& snapshot) {
    if (++looks_ != static_cast<int>(2.0 * kAllShouldRun)) return;
    for (const config::RosBinding& binding : bindings_) {
      const std::string& name = graph_.node(binding.node).name;
      const auto node = std::find_if(snapshot.nodes.begin(), snapshot.nodes.end(),
                                     [&](const NodeSnapshot& one) { return one.name == name; });
      if (node == snapshot.nodes.end() || node->compute_ms.count > 0) continue;
      note(fmt::format(
          "node {} has not run in {} s: its ROS node {} has not come, or has no such callback, or a node of "
          "the same subchain is missing; the others go on",
          name, kAllShouldRun, binding.callback.node));
    }
  }

 private:
  const graph::Graph& graph_;
  std::vector<config::RosBinding> bindings_;
  int looks_ = 0;
};

// A server is there: the command takes the place of this process, so signals and its exit code are its own.
int join(const RosRunOptions& options, const std::vector<std::string>& environment) {
  for (const std::string& entry : environment) {
    const std::size_t equals = entry.find('=');
    ::setenv(entry.substr(0, equals).c_str(), entry.c_str() + equals + 1, 1);
  }
  ::setenv(runtime::kSocketVariable, std::filesystem::absolute(options.socket).c_str(), 1);
  std::vector<char*> words;
  for (const std::string& word : options.command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ::execvp(words[0], words.data());
  return report_error(Error::caller(fmt::format("{} cannot be started", quote(options.command[0])),
                                    "name a program that is there, with its path or in PATH"));
}

int run(const RosRunOptions& options) {
  auto file = config::load_app_file(options.app);
  if (!file) return report_error(file.error());
  const auto bindings = load_bindings(*file, options);
  if (!bindings) return report_error(bindings.error());
  if (!options.socket.empty()) {
    const auto environment = environment_of(file->app.graph, *bindings, options.socket);
    return environment ? join(options, *environment) : report_error(environment.error());
  }

  if (Status fits = options.watched.check(file->app, options.scheduling.flight_recorder_mib); !fits) {
    return report_error(fits.error());
  }
  const auto folder = TemporaryFolder::make("catan-ros");
  if (!folder) return report_error(folder.error());
  const std::string socket = (*folder)->path() + "/socket";
  auto environment = environment_of(file->app.graph, *bindings, socket);
  if (!environment) return report_error(environment.error());
  const std::string record_path =
      options.scheduling.record.empty() ? (*folder)->path() + "/run.catan" : options.scheduling.record;
  ServingOptions serving;
  serving.socket = socket;
  serving.commands = {options.command};
  serving.environment = std::move(*environment);
  serving.seconds = options.seconds;
  Missing missing(file->app.graph, *bindings);
  const auto served = serve_programs(*file, options.scheduling, options.watched, record_path, std::move(serving),
                                     fmt::format("{}", fmt::join(options.command, " ")),
                                     [&missing](const Snapshot& snapshot) { missing.look(snapshot); });
  if (!served) return report_error(served.error());
  return show_served(*served, record_path, options.json);
}

void add_ros_run_command(CLI::App& ros, int& exit_code) {
  auto options = std::make_shared<RosRunOptions>();
  CLI::App* command = ros.add_subcommand("run", "Schedule the ROS 1 programs that a command starts");
  command->footer(
      "Examples:\n"
      "  sudo -E catan ros run robot.yaml -- roslaunch my_robot all.launch    serves the app, ends with the command\n"
      "  catan ros run robot.yaml --bind bind.yaml --record run.catan -- rosrun my_robot mapper\n"
      "  catan ros run robot.yaml --scheduler default --seconds 60 -- roslaunch my_robot all.launch    to compare "
      "with\n"
      "  catan ros run robot.yaml --socket /run/catan/robot.sock -- rosrun my_robot mapper    joins a server\n"
      "Callbacks that a binding names become runs of their nodes; the others, and programs without any, stay as they "
      "are.\n"
      "docs/ros1.md says more. Ctrl-C and SIGTERM end it and all that the command has started.\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake, 128 + the signal's number if a signal ended it; else "
      "it "
      "is\nCOMMAND's, where Catan did what it was asked. With --socket it is COMMAND's.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--bind", options->bind, "Which callback is which node, beside what the app file says")
      ->type_name("FILE");
  command
      ->add_option("--socket", options->socket, "Join the server that listens there, in place of a server of its own")
      ->type_name("PATH");
  command
      ->add_option("--seconds", options->seconds,
                   "How long to measure, after the warm-up; else as long as COMMAND runs")
      ->check(within(0.1, 864'000.0));
  options->scheduling.add_to(*command);
  options->watched.add_to(*command);
  command->add_option("COMMAND", options->command, "Starts the programs: roslaunch, rosrun, a script")
      ->type_name("-- COMMAND...")
      ->required();
  command->add_flag("--json", options->json, "Print one JSON document");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace

void add_ros_command(CLI::App& cli, int& exit_code) {
  CLI::App* command = cli.add_subcommand("ros", "Schedule ROS 1 programs that nobody changed");
  command->footer(
      "Examples:\n"
      "  catan ros run robot.yaml -- roslaunch my_robot all.launch    see catan ros run --help\n"
      "  catan ros bind -- roslaunch my_robot all.launch              writes a first app file, app.yaml\n"
      "  catan ros node                                               tells rqt, rosbag and others what happens\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake.");
  command->require_subcommand(1);
  add_ros_bind_command(*command, exit_code);
  add_ros_node_command(*command, exit_code);
  add_ros_run_command(*command, exit_code);
}

}  // namespace ctn::tool
