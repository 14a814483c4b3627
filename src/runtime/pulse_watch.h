// Tells whether a server still does something: by its pulse (region.h), at which a program looks now and then. It
// counts looks, not time, so that a machine that stood still as a whole is not taken for a server that does. Pure.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/time.h"

namespace ctn::runtime {

class PulseWatch {
 public:
  static constexpr Nanos kLook = std::chrono::milliseconds{50};

  // Of a new server.
  void begin(TimePoint now, std::uint32_t beats) {
    beats_ = beats;
    in_vain_ = 0;
    next_look_ = now + kLook;
  }
  TimePoint next_look() const { return next_look_; }
  // False: it has ceased. `longest_pause`: as the server says, which need not be sensible; 0: it has no pulse.
  bool lives(TimePoint now, std::uint32_t beats, Nanos longest_pause) {
    if (now < next_look_) return true;
    next_look_ = now + kLook;
    in_vain_ = beats == beats_ ? in_vain_ + 1 : 0;
    beats_ = beats;
    return longest_pause <= Nanos{0} || in_vain_ * kLook < std::clamp(longest_pause, kShortest, kLongest);
  }

 private:
  static constexpr Nanos kShortest = std::chrono::milliseconds{100};
  static constexpr Nanos kLongest = std::chrono::seconds{10};

  std::uint32_t beats_ = 0;
  int in_vain_ = 0;  // looks since the last beat
  TimePoint next_look_{};
};

}  // namespace ctn::runtime
