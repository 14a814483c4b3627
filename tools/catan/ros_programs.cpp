#include "ros_programs.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "command.h"
#include "common/binding.h"
#include "config/app_file.h"
#include "config/ros_binding.h"

namespace ctn::tool {
namespace {

catan_ros::Binding::Kind bound_kind(config::RosCallback::Kind kind) {
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

std::vector<ProgramCallback> bound_ros_callbacks(const std::vector<config::RosBinding>& bindings) {
  std::vector<ProgramCallback> bound;
  for (const auto& [node, callback] : bindings) {
    bound.push_back(
        {node, bound_kind(callback.kind), callback.node, callback.name, callback.period, {}, callback.nodelet});
  }
  return bound;
}

Result<std::vector<config::RosBinding>> load_ros_bindings(const config::AppFile& file, const RosRunOptions& options) {
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
  if (bindings) {
    const Status fits = options.has_nodelets ? config::check_services(*bindings, file.app)
                                             : config::check_without_nodelets(*bindings, file.app);
    if (!fits) return fits.error();
  }
  return bindings;
}

}  // namespace

std::string missing_ros_node(const std::string& ros_node) {
  return fmt::format("its ROS node {} has not come, or has no such callback", ros_node);
}

void RosRunOptions::add_to(CLI::App& command_line, const std::string& starts) {
  command_line.add_option("--bind", bind, "Which callback is which node, beside what the app file says")
      ->type_name("FILE");
  programs.add_to(command_line, starts);
}

int run_ros_programs(const RosRunOptions& options, const RosSide& side) {
  auto file = config::load_app_file(options.programs.app);
  if (!file) return report_error(file.error());
  const auto bindings = load_ros_bindings(*file, options);
  if (!bindings) return report_error(bindings.error());
  file->app.graph = file->app.graph.needing_input(config::nodes_needing_input(*bindings));
  BoundPrograms programs;
  programs.callbacks = bound_ros_callbacks(*bindings);
  programs.bindings_variable = catan_ros::kBindingsVariable;
  programs.why_missing = side.why_missing;
  programs.environment = side.environment;
  return run_bound_programs(*file, options.programs, programs);
}

}  // namespace ctn::tool
