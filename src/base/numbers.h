// Numbers that have a name.
#pragma once

#include <limits>

namespace ctn {

// Stands for: no bound, never reached, or worse than any value.
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace ctn
