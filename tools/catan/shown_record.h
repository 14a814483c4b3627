// What `run` and `ros run` print at their end.
#pragma once

#include <string>

namespace ctn::tool {

// The record's report; `warm`: its warm-up ended, and is left out. The exit code.
int show_record(const std::string& path, bool warm, bool json);

}  // namespace ctn::tool
