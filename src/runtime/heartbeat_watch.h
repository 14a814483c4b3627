// Tells whether a server still does something: by its heartbeat (region.h), at which a program looks now and then. It
// counts looks, not time, so that a machine that stood still as a whole is not taken for a server that does.
//
// A server that has ceased is taken for alive again only when its heartbeat has gone on since; until then it may be
// looked at as often as one likes, so that it is seen soon.
//
// Pure. Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/time.h"

namespace ctn::runtime {

class HeartbeatWatch {
 public:
  static constexpr Nanos kLook = std::chrono::milliseconds{50};
  // How often to look at a server that has ceased.
  static constexpr Nanos kLookForLife = std::chrono::milliseconds{10};

  // Of a new server, or one that is to be judged anew.
  void begin(TimePoint now, std::uint32_t beats) {
    beats_ = beats;
    in_vain_ = 0;
    ceased_ = false;
    next_look_ = now + kLook;
  }
  TimePoint next_look() const { return next_look_; }
  // False: it has ceased. `longest_pause`: as the server says, which need not be sensible; 0: it has no heartbeat.
  bool lives(TimePoint now, std::uint32_t beats, Nanos longest_pause) {
    if (now < next_look_ && !ceased_) return true;
    if (ceased_ && beats == beats_) {
      next_look_ = now + kLookForLife;
      return false;
    }
    next_look_ = now + kLook;
    in_vain_ = beats == beats_ ? in_vain_ + 1 : 0;
    beats_ = beats;
    ceased_ = longest_pause > Nanos{0} && in_vain_ * kLook >= std::clamp(longest_pause, kShortest, kLongest);
    if (ceased_) next_look_ = now + kLookForLife;
    return !ceased_;
  }

 private:
  static constexpr Nanos kShortest = std::chrono::milliseconds{100};
  static constexpr Nanos kLongest = std::chrono::seconds{10};

  std::uint32_t beats_ = 0;
  int in_vain_ = 0;  // looks since the last beat
  bool ceased_ = false;
  TimePoint next_look_{};
};

}  // namespace ctn::runtime
