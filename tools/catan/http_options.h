// How a page is served: options of `catan http` and of `catan serve --http`, which starts the first.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "os/cpu_set.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace ctn::tool {

constexpr const char* kDefaultHttpAddress = "127.0.0.1:8080";

struct HttpOptions {
  std::string address;  // empty: there is no page
  bool allow_control = false;
  std::string token_file;  // empty: a token is made
  std::string cpus;        // that nodes may use, where the one that starts it knows; empty: it does not

  // `needed`: an option without which these make no sense; none: there is none.
  void add_control_to(CLI::App& command, CLI::Option* needed = nullptr);
  std::optional<os::CpuSet> scheduled() const;

  // This command, to be started for a server that listens at `socket`, and to end with the calling thread.
  std::vector<std::string> command_line(const std::string& socket) const;
};

}  // namespace ctn::tool
