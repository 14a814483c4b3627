// catan ros2: schedules ROS 2 programs whose executor is Catan's.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "command.h"
#include "common/binding.h"
#include "port_libraries.h"
#include "ros_programs.h"
#include "shared_file_path.h"

namespace ctn::tool {
namespace {

int run_ros2(const RosRunOptions& options) {
  const auto environment = [](const std::string& socket) -> Result<std::vector<std::string>> {
    auto preload = threads_preload_entry();
    if (!preload) return preload.error();
    return std::vector<std::string>{
        std::move(*preload), fmt::format("{}={}", catan_ros::kRunTimesVariable, shared_file_path(socket, ".runs"))};
  };
  return run_ros_programs(options, {environment, missing_ros_node});
}

}  // namespace

void add_ros2_command(CLI::App& cli, int& exit_code) {
  CLI::App* ros = cli.add_subcommand("ros2", "Schedule ROS 2 programs and components");
  ros->footer(
      "Examples:\n"
      "  catan ros2 run robot.yaml -- ros2 launch my_robot all.launch.py    see catan ros2 run --help\n"
      "  catan plan robot.yaml --costs run.catan --format cie               for Autoware's executor: see catan plan "
      "--help\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake.");
  ros->require_subcommand(1);
  auto options = std::make_shared<RosRunOptions>();
  CLI::App* command = ros->add_subcommand("run", "Schedule the ROS 2 programs that a command starts");
  command->footer(
      "Examples:\n"
      "  sudo -E catan ros2 run robot.yaml -- ros2 launch my_robot all.launch.py    serves the app, ends with the "
      "command\n"
      "  catan ros2 run robot.yaml --bind bind.yaml --record run.catan -- ros2 run my_robot mapper\n"
      "  catan ros2 run robot.yaml --scheduler default --seconds 60 -- ros2 launch my_robot all.launch.py    to "
      "compare with\n"
      "  catan ros2 run robot.yaml --socket /run/catan/robot.sock -- ros2 run my_robot mapper    joins a server\n"
      "Callbacks that a binding names become runs of their nodes where the program's executor is "
      "catan_ros2::Executor,\n"
      "or its container catan_component_container; all else stays as it is. docs/ros2.md says more. Ctrl-C and SIGTERM "
      "end\nit and all that the command has started.\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake, 128 + the signal's number if a signal ended it; else "
      "it "
      "is\nCOMMAND's, where Catan did what it was asked. With --socket it is COMMAND's.");
  options->add_to(*command, "Starts the programs: ros2 launch, ros2 run, a script");
  command->callback([options, &exit_code] { exit_code = run_ros2(*options); });
}

}  // namespace ctn::tool
