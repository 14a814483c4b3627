// catan: the command line. See command.h for how a subcommand is added.
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "base/text.h"
#include "command.h"

namespace ctn::tool {
namespace {

constexpr const char* kFooter =
    "Examples:\n"
    "  catan check app.yaml\n"
    "  catan plan app.yaml --cores 4 --costs costs.yaml\n"
    "  catan sim app.yaml --cores 4 --costs costs.yaml\n"
    "  catan run app.yaml --synthetic costs.yaml\n"
    "  catan run app.yaml -- ros2 launch my_robot all.launch.py\n"
    "  catan top\n"
    "  catan doctor\n"
    "  catan bench\n"
    "\n"
    "'catan COMMAND --help' says more about a command.\n"
    "Exit code: 0 success, 1 failure at run time, 2 a mistake in a file or on the command line; of 'catan run -- "
    "COMMAND'\n"
    "that of COMMAND, where Catan did what it was asked.";

int report_usage(const CLI::App& cli, const CLI::ParseError& error, int argc, char** argv) {
  const bool names_command = argc > 1 && argv[1][0] != '-';
  if (names_command && cli.get_subcommands().empty()) {
    std::vector<std::string> commands;
    for (const CLI::App* command : cli.get_subcommands({})) commands.push_back(command->get_name());
    const auto meant = nearest(argv[1], commands);
    note(fmt::format("there is no command {}; {}", quote(argv[1]),
                     meant ? fmt::format("did you mean {}?", quote(*meant)) : "see catan --help"));
    return kMistake;
  }
  const auto chosen = cli.get_subcommands();
  note(fmt::format("{}; see catan {}--help", error.what(), chosen.empty() ? "" : chosen.front()->get_name() + " "));
  return kMistake;
}

// A full disk or a closed pipe must not look like success.
int check_output(int exit_code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.flush()) return exit_code;
  return report_error(Error::environment("the output could not be written", "check where stdout goes"));
}

int run(int argc, char** argv) {
  CLI::App cli{"Catan schedules the CPUs of sense-react applications while they run.", "catan"};
  cli.footer(kFooter);
  cli.set_version_flag("--version", "catan " CATAN_VERSION);
  cli.require_subcommand(1);
  int exit_code = kSuccess;
  add_bench_command(cli, exit_code);
  add_check_command(cli, exit_code);
  add_doctor_command(cli, exit_code);
  add_plan_command(cli, exit_code);
  add_run_command(cli, exit_code);
  add_serve_command(cli, exit_code);
  add_node_command(cli, exit_code);
  add_ros_command(cli, exit_code);
  add_ros2_command(cli, exit_code);
  add_illixr_command(cli, exit_code);
  add_ctl_command(cli, exit_code);
  add_top_command(cli, exit_code);
  add_http_command(cli, exit_code);
  add_report_command(cli, exit_code);
  add_export_command(cli, exit_code);
  add_sim_command(cli, exit_code);
  add_watch_command(cli, exit_code);
  add_whatif_command(cli, exit_code);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // --help and --version come this way too.
    exit_code = error.get_exit_code() == 0 ? cli.exit(error) : report_usage(cli, error, argc, argv);
  }
  return check_output(exit_code);
}

}  // namespace
}  // namespace ctn::tool

int main(int argc, char** argv) {
  int exit_code = ctn::tool::kFailure;
  try {
    exit_code = ctn::tool::run(argc, argv);
  } catch (const std::exception& exception) {
    ctn::tool::note(fmt::format("this is a bug in catan: {}", exception.what()));
  }
  ctn::tool::finish_stderr();
  return exit_code;
}
