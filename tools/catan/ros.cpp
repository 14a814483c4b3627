// catan ros: schedules ROS programs that nobody changed.
#include <fmt/format.h>

#include <chrono>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "bound_programs.h"
#include "command.h"
#include "common/binding.h"
#include "port_libraries.h"
#include "ros_bind.h"
#include "ros_master.h"
#include "ros_node.h"
#include "ros_programs.h"
#include "shared_file_path.h"

namespace ctn::tool {
namespace {

// As the master tells, which is asked for no longer than this in all.
constexpr std::chrono::seconds kAskAtMost{2};
constexpr std::size_t kMostNodes = 20;  // that are named

class WhyMissing {
 public:
  std::string operator()(const std::string& node) {
    const auto now = std::chrono::steady_clock::now();
    if (!until_) until_ = now + kAskAtMost;
    if (now >= *until_) return missing_ros_node(node);
    switch (RosMaster::from_environment().node(node)) {
      case RosMaster::Node::kUnknown:
        return fmt::format("its ROS node {} has not come{}", node, those_there());
      case RosMaster::Node::kPython:
        return fmt::format(
            "its ROS node {} is written in Python, whose callbacks cannot be triggered (write external: true in place "
            "of its binding)",
            node);
      case RosMaster::Node::kOther:
        break;
    }
    return fmt::format("its ROS node {} has no such callback, or was not started by the command", node);
  }

 private:
  // Of the nodes that publish or subscribe anything.
  static std::string those_there() {
    const auto connections = RosMaster::from_environment().connections();
    if (!connections) return "";
    std::set<std::string> nodes;
    for (const auto* const topics : {&connections->publishers, &connections->subscribers}) {
      for (const auto& [topic, names] : *topics) nodes.insert(names.begin(), names.end());
    }
    nodes.erase("/rosout");
    if (nodes.empty()) return "";
    const bool some = nodes.size() > kMostNodes;
    while (nodes.size() > kMostNodes) nodes.erase(std::prev(nodes.end()));
    return fmt::format(" (there are {}{})", fmt::join(nodes, ", "), some ? ", ..." : "");
  }

  std::optional<std::chrono::steady_clock::time_point> until_;
};

int run(const RosRunOptions& options) {
  const auto environment = [](const std::string& socket) -> Result<std::vector<std::string>> {
    auto preload = ros_preload_entry();
    if (!preload) return preload.error();
    return std::vector<std::string>{std::move(*preload), fmt::format("{}={}", catan_ros::kMessageRunsVariable,
                                                                     shared_file_path(socket, ".messages"))};
  };
  return run_ros_programs(options, {environment, WhyMissing()});
}

void add_ros_run_command(CLI::App& ros, int& exit_code) {
  auto options = std::make_shared<RosRunOptions>();
  options->has_nodelets = true;
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
  options->add_to(*command, "Starts the programs: roslaunch, rosrun, a script");
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
