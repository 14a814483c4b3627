// Moments by their distance from the clock's zero; for tests.
#pragma once

#include <chrono>

#include "base/time.h"

namespace ctn {

constexpr TimePoint at(Nanos since_zero) { return TimePoint{} + since_zero; }
constexpr TimePoint at_ms(int since_zero) { return at(std::chrono::milliseconds{since_zero}); }

}  // namespace ctn
