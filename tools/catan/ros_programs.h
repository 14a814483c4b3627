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

// `environment` is that of BoundPrograms. The command's exit code.
int run_ros_programs(const RosRunOptions& options,
                     const std::function<Result<std::vector<std::string>>(const std::string& socket)>& environment);

}  // namespace ctn::tool
