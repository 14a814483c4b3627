// A shell command as a script sees it: what it prints, and how it ends.
#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace ctn::program::testing {

struct Ended {
  int code = -1;
  std::string out;  // stdout; stderr goes with the test's
};

inline Ended run_command(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) return {};
  Ended ended;
  std::array<char, 4096> chunk{};
  while (const std::size_t length = std::fread(chunk.data(), 1, chunk.size(), pipe)) {
    ended.out.append(chunk.data(), length);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
  return ended;
}

}  // namespace ctn::program::testing
