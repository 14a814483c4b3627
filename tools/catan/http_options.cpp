#include "http_options.h"

#include <unistd.h>

#include <CLI/CLI.hpp>

#include "os/linux/privilege.h"

namespace ctn::tool {

void HttpOptions::add_control_to(CLI::App& command, CLI::Option* needed) {
  CLI::Option* allow =
      command.add_flag("--allow-control", allow_control,
                       "Let clients that send the token change weights, bounds and CPUs; else the page only shows");
  if (needed != nullptr) allow->needs(needed);
  command
      .add_option("--token-file", token_file, "Take the token from this file, instead of generating and printing one")
      ->type_name("FILE")
      ->needs(allow);
}

std::optional<os::CpuSet> HttpOptions::scheduled() const {
  const auto set = os::parse_cpu_list(cpus);
  return set ? std::optional(*set) : std::nullopt;
}

std::vector<std::string> HttpOptions::command_line(const std::string& socket) const {
  std::vector<std::string> arguments{os::program_path({}),      "http", socket, "--listen", address, "--parent",
                                     std::to_string(::getpid())};
  if (!cpus.empty()) arguments.insert(arguments.end(), {"--scheduled-cpus", cpus});
  if (allow_control) arguments.emplace_back("--allow-control");
  if (!token_file.empty()) arguments.insert(arguments.end(), {"--token-file", token_file});
  return arguments;
}

}  // namespace ctn::tool
