// Running ROS programs, of ROS 1 or 2, whose callbacks are nodes by the app file or a bind file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "bound_programs.h"

namespace ctn::tool {

struct RosRunOptions {
  BoundProgramsOptions programs;
  std::string bind;
  bool has_nodelets = false;  // ROS 1

  // `starts` says what COMMAND is.
  void add_to(CLI::App& command_line, const std::string& starts);
};

// What is not the same in ROS 1 and 2; as in BoundPrograms.
struct RosSide {
  std::function<Result<std::vector<std::string>>(const std::string& socket)> environment;
  std::function<std::string(const std::string& program)> why_missing;
};

// What is wrong with a bound node that did not run, as far as nobody can be asked.
std::string missing_ros_node(const std::string& ros_node);

// The command's exit code.
int run_ros_programs(const RosRunOptions& options, const RosSide& side);

}  // namespace ctn::tool
