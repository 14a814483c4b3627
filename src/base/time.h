// Time as the modules see it: values that are passed in, never a clock that is read.
//
//   Nanos       a duration, whole nanoseconds. What the runtime, the record and the operating system speak.
//   Millis      a duration, floating milliseconds. What the planner computes in and what files show.
//   TimePoint   an instant of the monotonic clock. Its clock type has no now(): only an `os::Os` can tell the time.
//   Rate        a frequency in hertz, always positive.
//
// Thread safety: plain values.
#pragma once

#include <chrono>
#include <cmath>
#include <compare>
#include <cstdint>
#include <ratio>

namespace ctn {

using Nanos = std::chrono::nanoseconds;
using Millis = std::chrono::duration<double, std::milli>;

struct MonotonicClock {
  using duration = Nanos;
  using rep = Nanos::rep;
  using period = Nanos::period;
  using time_point = std::chrono::time_point<MonotonicClock, Nanos>;
  static constexpr bool is_steady = true;
};
using TimePoint = MonotonicClock::time_point;

constexpr TimePoint kNever = TimePoint::max();

constexpr Millis to_millis(Nanos duration) { return duration; }

constexpr double in_seconds(Nanos duration) { return std::chrono::duration<double>(duration).count(); }

// Rounds to the nearest nanosecond. Range: |duration| below 292 years; the caller's inputs are bounded far below that.
inline Nanos to_nanos(Millis duration) { return Nanos{std::llround(duration.count() * 1e6)}; }

class Rate {
 public:
  // Precondition: hertz > 0 and finite.
  explicit constexpr Rate(double hertz) : hertz_(hertz) {}

  constexpr double hertz() const { return hertz_; }
  constexpr Millis period() const { return Millis{1000.0 / hertz_}; }
  static constexpr Rate every(Millis period) { return Rate{1000.0 / period.count()}; }

  friend constexpr auto operator<=>(Rate, Rate) = default;

 private:
  double hertz_;
};

}  // namespace ctn
