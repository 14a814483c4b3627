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
  static constexpr Nanos kCheckPeriod = std::chrono::milliseconds{50};
  // How often to look at a server that has ceased.
  static constexpr Nanos kResumeCheckPeriod = std::chrono::milliseconds{10};

  // Of a new server, or one that is to be judged again.
  void begin(TimePoint now, std::uint32_t beats) {
    beats_seen_ = beats;
    missed_ = 0;
    stopped_ = false;
    next_check_ = now + kCheckPeriod;
  }
  TimePoint next_check() const { return next_check_; }
  // False: it has ceased. `max_heartbeat_gap`: as the server says, which need not be sensible; 0: it has no heartbeat.
  bool alive(TimePoint now, std::uint32_t beats, Nanos max_heartbeat_gap) {
    if (now < next_check_ && !stopped_) return true;
    if (stopped_ && beats == beats_seen_) {
      next_check_ = now + kResumeCheckPeriod;
      return false;
    }
    next_check_ = now + kCheckPeriod;
    missed_ = beats == beats_seen_ ? missed_ + 1 : 0;
    beats_seen_ = beats;
    stopped_ =
        max_heartbeat_gap > Nanos{0} && missed_ * kCheckPeriod >= std::clamp(max_heartbeat_gap, kShortest, kLongest);
    if (stopped_) next_check_ = now + kResumeCheckPeriod;
    return !stopped_;
  }

 private:
  static constexpr Nanos kShortest = std::chrono::milliseconds{100};
  static constexpr Nanos kLongest = std::chrono::seconds{10};

  std::uint32_t beats_seen_ = 0;
  int missed_ = 0;  // looks since the last beat
  bool stopped_ = false;
  TimePoint next_check_{};
};

}  // namespace ctn::runtime
