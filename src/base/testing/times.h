// Moments by their distance from the clock's zero, and durations in milliseconds; for tests.
#pragma once

#include <chrono>

#include "base/time.h"

namespace ctn {

constexpr TimePoint at(Nanos since_zero) { return TimePoint{} + since_zero; }
inline Nanos ms(double duration) { return to_nanos(Millis{duration}); }
constexpr TimePoint at_ms(int since_zero) { return at(std::chrono::milliseconds{since_zero}); }

}  // namespace ctn
