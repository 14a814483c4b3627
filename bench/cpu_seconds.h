// For benchmarks: CPU time of this process, all its threads together.
#pragma once

#include <ctime>

namespace ctn::bench {

inline double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace ctn::bench
