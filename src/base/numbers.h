// Numbers that have a name.
#pragma once

#include <limits>

namespace ctn {

// Of what has no bound, was not reached, or is to be beaten by anything.
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace ctn
