// How the live page is served: options of `catan http`, and of `catan serve --http`, which starts `catan http`.
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
  std::string token_file;  // empty: a token is generated
  std::string cpus;        // CPUs that nodes may use, from the server that starts this; empty: not known

  // `needed`: the option without which these make no sense, if any.
  void add_control_to(CLI::App& command, CLI::Option* needed = nullptr);
  std::optional<os::CpuSet> scheduled() const;

  // The command line of a `catan http` for the server that listens at `socket`; it ends with the calling thread.
  std::vector<std::string> command_line(const std::string& socket) const;
};

}  // namespace ctn::tool
