// What all subcommands share: exit codes, and how errors are shown.
//
// A subcommand is one file with one function, `void add_NAME_command(CLI::App& cli, int& exit_code)`: it adds the
// command and its options, with a callback that does the work and sets `exit_code`. Declare it below, call it in
// main.cpp. Data go to stdout, everything else to stderr.
#pragma once

#include <string_view>

#include "base/result.h"

namespace CLI {
class App;
}

namespace ctn::tool {

constexpr int kSuccess = 0;
constexpr int kFailure = 1;  // the machine said no
constexpr int kMistake = 2;  // the user's mistake

// On stderr, as far as that can be written: a log that is full, or whose reader is gone, is no reason to end.
void print_on_stderr(std::string_view text);

// Prints every problem on stderr, one a line, and gives the exit code of its kind.
int report_error(const Error& error);

// For what the user should know but need not correct; on stderr.
void note(std::string_view text);

// Prints on stdout. Whether all of it could be written is checked once, by main.
void print(std::string_view text);

// For commands that go on while an app runs: from now on a pipe that nobody reads any more does not end the process (it
// does end programs that this one starts, as usual), and nobody waits for stderr to be read (os/linux/log_output.h).
void outlive_readers();
// For main, at the end: waits a moment for what is not read yet.
void finish_stderr();

// Whether a person with a terminal that shows colours reads what print() writes.
bool stdout_has_colours();

void add_bench_command(CLI::App& cli, int& exit_code);
void add_check_command(CLI::App& cli, int& exit_code);
void add_ctl_command(CLI::App& cli, int& exit_code);
void add_doctor_command(CLI::App& cli, int& exit_code);
void add_export_command(CLI::App& cli, int& exit_code);
void add_http_command(CLI::App& cli, int& exit_code);
void add_illixr_command(CLI::App& cli, int& exit_code);
void add_node_command(CLI::App& cli, int& exit_code);
void add_plan_command(CLI::App& cli, int& exit_code);
void add_report_command(CLI::App& cli, int& exit_code);
void add_ros_command(CLI::App& cli, int& exit_code);
void add_ros2_command(CLI::App& cli, int& exit_code);
void add_run_command(CLI::App& cli, int& exit_code);
void add_serve_command(CLI::App& cli, int& exit_code);
void add_sim_command(CLI::App& cli, int& exit_code);
void add_top_command(CLI::App& cli, int& exit_code);
void add_watch_command(CLI::App& cli, int& exit_code);
void add_whatif_command(CLI::App& cli, int& exit_code);

}  // namespace ctn::tool
