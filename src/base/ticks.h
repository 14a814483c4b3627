// A clock that is not ours, as far as it is known: when it ticked, and how often it does.
//
// Thread safety: a plain value.
#pragma once

#include "base/time.h"

namespace ctn {

struct Ticks {
  TimePoint tick{};  // any one
  Nanos period{0};   // > 0 where there is a clock

  // The first tick that is not before `from`.
  constexpr TimePoint next(TimePoint from) const { return last(from + (period - Nanos{1})); }
  // The last tick that is not after `until`.
  constexpr TimePoint last(TimePoint until) const {
    const Nanos past = (until - tick) % period;
    return until - (past < Nanos{0} ? past + period : past);
  }

  friend constexpr bool operator==(const Ticks&, const Ticks&) = default;
};

}  // namespace ctn
