// A clock that ticks at equal distances, forever.
//
// Units: nanoseconds. Thread safety: a value.
#pragma once

#include <chrono>

namespace ctn::vr::run {

struct Clock {
  std::chrono::nanoseconds first{};  // any tick
  std::chrono::nanoseconds period{1};

  // The last tick that is not after `until`.
  std::chrono::nanoseconds last(std::chrono::nanoseconds until) const {
    const std::chrono::nanoseconds past = (until - first) % period;
    return until - (past < std::chrono::nanoseconds(0) ? past + period : past);
  }
  // The first tick that is not before `from`.
  std::chrono::nanoseconds next(std::chrono::nanoseconds from) const {
    return last(from + period - std::chrono::nanoseconds(1));
  }
};

inline double in_seconds(std::chrono::nanoseconds time) { return std::chrono::duration<double>(time).count(); }
inline double in_ms(std::chrono::nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

}  // namespace ctn::vr::run
