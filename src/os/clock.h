// The clock that everything is timed by.
//
// Units: TimePoint and Nanos of the monotonic clock. Thread safety: any thread at any time. Cost: now() is on the hot
// path; it never allocates or locks.
#pragma once

#include "base/time.h"

namespace ctn::os {

class Clock {
 public:
  virtual ~Clock() = default;

  virtual TimePoint now() = 0;
  virtual void sleep_until(TimePoint deadline) = 0;
};

}  // namespace ctn::os
