// For the tests' ROS programs, which know nothing of Catan: work.
//
// Thread safety: each thread burns its own CPU time.
#pragma once

#include <time.h>

// Uses so much CPU time of the thread.
inline void burn(double milliseconds) {
  timespec used{};
  const auto now = [&] {
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) * 1e3 + static_cast<double>(used.tv_nsec) * 1e-6;
  };
  const double end = now() + milliseconds;
  while (now() < end) {
  }
}
