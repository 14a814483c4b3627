// Serving an app to programs whose callbacks a binding makes nodes of: what `catan ros run` and `catan illixr run`
// share.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "base/ids.h"
#include "base/result.h"
#include "base/time.h"
#include "common/binding.h"
#include "config/app_file.h"
#include "scheduling_options.h"
#include "watch.h"

namespace ctn::tool {

struct BoundProgramsOptions {
  std::string app;
  std::string socket;  // of a server to join; empty: one of its own
  std::vector<std::string> command;
  SchedulingOptions scheduling;
  WatchedApp watched;
  std::optional<double> seconds;
  bool json = false;

  // `starts` says what COMMAND is.
  void add_to(CLI::App& command_line, const std::string& starts);
};

// A node, and where its callback is to be found.
struct ProgramCallback {
  NodeId node;
  catan_ros::Binding::Kind kind = catan_ros::Binding::Kind::kTopic;
  std::string program;  // a ROS node, a plugin
  std::string name;     // of a topic or service
  Nanos period{0};      // of a timer
  // On which topics what it publishes is output (none: any). Not set: those that its successors are bound to.
  std::optional<std::vector<std::string>> outputs;
  std::string nodelet{};  // of the ROS node; empty: any
};

struct BoundPrograms {
  std::vector<ProgramCallback> callbacks;
  std::string bindings_variable;  // of the environment, by which programs are told of them
  // Why a node of that program has not run, as part of a sentence. Called once a node, while others run: to be quick.
  std::function<std::string(const std::string& program)> why_missing;
  // What else programs are told, as NAME=VALUE, where the server listens at `socket`, an absolute path.
  std::function<Result<std::vector<std::string>>(const std::string& socket)> environment;
};

// The command's exit code.
int run_bound_programs(const config::AppFile& file, const BoundProgramsOptions& options, const BoundPrograms& programs);

}  // namespace ctn::tool
