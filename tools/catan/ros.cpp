// catan ros: schedules ROS programs that nobody changed.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "bound_programs.h"
#include "command.h"
#include "common/binding.h"
#include "config/app_file.h"
#include "config/ros_binding.h"
#include "port_libraries.h"
#include "ros_bind.h"
#include "ros_node.h"

namespace ctn::tool {
namespace {

struct RosRunOptions {
  BoundProgramsOptions programs;
  std::string bind;
};

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

std::vector<BoundCallback> bound_callbacks(const std::vector<config::RosBinding>& bindings) {
  std::vector<BoundCallback> bound;
  for (const auto& [node, callback] : bindings) {
    bound.push_back({node, kind_of(callback.kind), callback.node, callback.name, callback.period, {}});
  }
  return bound;
}

Result<std::vector<config::RosBinding>> load_bindings(const config::AppFile& file, const RosRunOptions& options) {
  const auto bindings = [&]() -> Result<std::vector<config::RosBinding>> {
    if (options.bind.empty()) return config::ros_bindings(file.text, options.programs.app, file.app);
    const auto text = config::read_text(options.bind);
    if (!text) return text.error();
    return config::ros_bindings(file.text, options.programs.app, file.app, *text, options.bind);
  }();
  if (bindings && bindings->empty()) {
    return Error::caller(fmt::format("no node of app {} is a callback of a ROS program", file.app.name),
                         "write ros: {node: /mapper, topic: /scan} at its nodes, or give a file with --bind "
                         "(docs/ros1.md)");
  }
  return bindings;
}

int run(const RosRunOptions& options) {
  const auto file = config::load_app_file(options.programs.app);
  if (!file) return report_error(file.error());
  const auto bindings = load_bindings(*file, options);
  if (!bindings) return report_error(bindings.error());
  BoundPrograms programs;
  programs.callbacks = bound_callbacks(*bindings);
  programs.bindings_variable = catan_ros::kBindingsVariable;
  programs.missing = "its ROS node {} has not come, or has no such callback";
  programs.environment = [](const std::string& socket) -> Result<std::vector<std::string>> {
    auto preload = ros_preload_entry();
    if (!preload) return preload.error();
    // The file of messages lies beside the socket.
    return std::vector<std::string>{std::move(*preload),
                                    fmt::format("{}={}.messages", catan_ros::kMessageRunsVariable, socket)};
  };
  return run_bound_programs(*file, options.programs, programs);
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
  command->add_option("--bind", options->bind, "Which callback is which node, beside what the app file says")
      ->type_name("FILE");
  options->programs.add_to(*command, "Starts the programs: roslaunch, rosrun, a script");
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
