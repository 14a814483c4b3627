// What the demonstration needs to know about the machine.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace ctn::demo {

struct Host {
  std::vector<std::pair<std::string, std::string>> facts;  // name and value, for the page
  std::vector<std::vector<int>> cpu_sets;                  // one CPU; and two of different cores, where there are two
  std::string no_real_time;                                // empty where real-time levels may be set
};

Result<Host> look_at_host();

}  // namespace ctn::demo
