// Runs the real `catan` command the way a shell does, and hands back all it said.
#pragma once

#include <string>

namespace ctn::test {

struct Outcome {
  int exit_code = -1;  // 124: did not end within 20 s, under sanitizers 120 s; 128 + n: killed by signal n
  std::string out;
  std::string err;
};

// `arguments` as a shell reads them; run in `folder`.
Outcome run_catan(const std::string& arguments, const std::string& folder);

std::string read_all(const std::string& path);

}  // namespace ctn::test
