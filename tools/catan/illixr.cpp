// catan illixr: schedules plugins of ILLIXR.
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
#include "config/illixr_binding.h"
#include "port_libraries.h"

namespace ctn::tool {
namespace {

std::vector<ProgramCallback> bound_callbacks(const std::vector<config::IllixrBinding>& bindings) {
  std::vector<ProgramCallback> bound;
  for (const auto& [node, callback] : bindings) {
    const bool is_loop = callback.topic.empty();
    bound.push_back({node, is_loop ? catan_ros::Binding::Kind::kLoop : catan_ros::Binding::Kind::kTopic,
                     callback.plugin, callback.topic, Nanos{0}, callback.outputs});
  }
  return bound;
}

int run(const BoundProgramsOptions& options) {
  const auto file = config::load_app_file(options.app);
  if (!file) return report_error(file.error());
  const auto bindings = config::illixr_bindings(file->text, options.app, file->app);
  if (!bindings) return report_error(bindings.error());
  if (bindings->empty()) {
    return report_error(
        Error::caller(fmt::format("no node of app {} is of a plugin of ILLIXR", file->app.name),
                      "write illixr: {plugin: rk4_integrator, topic: imu} at its nodes (docs/illixr.md)"));
  }
  BoundPrograms programs;
  programs.callbacks = bound_callbacks(*bindings);
  programs.bindings_variable = catan_ros::kIllixrBindingsVariable;
  programs.why_missing = [](const std::string& plugin) {
    return fmt::format("plugin {} was not loaded, not behind Catan's header, or has no such callback", plugin);
  };
  programs.environment = [](const std::string&) -> Result<std::vector<std::string>> {
    auto preload = threads_preload_entry();
    if (!preload) return preload.error();
    return std::vector<std::string>{std::move(*preload)};
  };
  return run_bound_programs(*file, options, programs);
}

}  // namespace

void add_illixr_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<BoundProgramsOptions>();
  CLI::App* illixr = cli.add_subcommand("illixr", "Schedule plugins of ILLIXR");
  illixr->footer(
      "Examples:\n"
      "  catan illixr run headset.yaml -- main.opt.exe --yaml=headset-profile.yaml    see catan illixr run --help\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake.");
  illixr->require_subcommand(1);
  CLI::App* command = illixr->add_subcommand("run", "Schedule the plugins that an ILLIXR program loads");
  command->footer(
      "Examples:\n"
      "  sudo -E catan illixr run headset.yaml -- main.opt.exe --yaml=profile.yaml    serves the app, ends with "
      "ILLIXR\n"
      "  catan illixr run headset.yaml --scheduler default -- main.opt.exe --yaml=profile.yaml    to compare with\n"
      "  catan illixr run headset.yaml --socket /run/catan/headset.sock -- main.opt.exe ...    joins a server\n"
      "The profile's first plugin is catan; threadloops and callbacks that the app file names become runs of their\n"
      "nodes, all others stay as they are. docs/illixr.md says more. Ctrl-C and SIGTERM end it.\n"
      "Exit code: 0 it ran, 1 failure at run time, 2 a mistake, 128 + the signal's number if a signal ended it; else\n"
      "it is COMMAND's, where Catan did what it was asked. With --socket it is COMMAND's.");
  options->add_to(*command, "Starts ILLIXR");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace ctn::tool
