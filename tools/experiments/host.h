// What an experiment needs to know about the machine.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "report/table.h"

namespace ctn::experiments {

using Facts = std::vector<std::pair<std::string, std::string>>;  // name and value

// For the page.
report::Table table_of(const Facts& facts);

struct Host {
  Facts facts;
  std::vector<std::vector<int>> cpu_sets;  // one CPU; and two of different cores, where there are two
  std::string no_real_time;                // why real-time levels may not be set, and how to let them; or empty
};

// `program`: the one that is to be real-time, for the advice how.
Result<Host> look_at_host(const std::string& program);

}  // namespace ctn::experiments
