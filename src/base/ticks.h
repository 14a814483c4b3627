// A clock that is not ours, as far as it is known: when it ticked, and how often it does.
//
// Thread safety: a plain value.
#pragma once

#include <cstdint>

#include "base/time.h"

namespace ctn {

struct Ticks {
  TimePoint tick{};         // any one
  Nanos period{0};          // > 0 where there is a clock
  std::int64_t number = 0;  // of that tick: a user of each so-many-th always finds the same ones

  // The first tick that is not before `from`.
  constexpr TimePoint next(TimePoint from) const { return last(from + (period - Nanos{1})); }
  // The last tick that is not after `until`.
  constexpr TimePoint last(TimePoint until) const {
    const Nanos past = (until - tick) % period;
    return until - (past < Nanos{0} ? past + period : past);
  }

  // One whose number is a multiple of that; `each` > 0.
  constexpr TimePoint numbered(std::int64_t each) const {
    const std::int64_t past = number % each;
    return tick - (past < 0 ? past + each : past) * period;
  }

  friend constexpr bool operator==(const Ticks&, const Ticks&) = default;
};

// How many ticks of a clock something lasts: so many divided by so many, in lowest terms.
struct TickCount {
  int ticks = 1;
  int parts = 1;

  constexpr Nanos of(Nanos period) const { return ticks * period / parts; }
  friend constexpr bool operator==(const TickCount&, const TickCount&) = default;
};

}  // namespace ctn
