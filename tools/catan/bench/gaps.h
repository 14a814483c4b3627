// How long a core takes to go from one busy thread to another, from what the threads themselves see: each does nothing
// but read the clock, and notes where it was away.
//
// Units: TimePoint, Nanos. Thread safety: a GapLog has one owner while its thread runs; the rest are pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/time.h"
#include "os/clock.h"

namespace ctn::tool {

// A thread's last reading before it was away, and its first one after.
struct Gap {
  TimePoint begin{};
  TimePoint end{};
};

class GapLog {
 public:
  static constexpr std::size_t kMax = 100'000;
  static constexpr Nanos kShortest = std::chrono::microseconds{2};

  GapLog() { gaps_.reserve(kMax); }

  // Keeps the CPU busy until then, whatever its level: a caller at a real-time level names a time that is near.
  void spin(os::Clock& os, TimePoint until);
  const std::vector<Gap>& gaps() const { return gaps_; }

 private:
  std::vector<Gap> gaps_;
};

// For each end of a slice at which a thread that was away came to run, how long after it its first instruction was; the
// ends at which none came before the next are left out. All ascending.
std::vector<Nanos> hand_overs(std::span<const TimePoint> slice_ends, std::span<const Gap> gaps);

}  // namespace ctn::tool
