// Tells whether a server still runs, by its heartbeat (region.h), which a program checks now and then. It counts
// checks, not time: when the whole machine stood still, the server is not taken to be stopped.
//
// Once the heartbeat has ceased, the server counts as running again only when the heartbeat goes on. Until then it may
// be checked as often as the caller likes.
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
  // How often to check a server whose heartbeat has ceased.
  static constexpr Nanos kResumeCheckPeriod = std::chrono::milliseconds{10};

  // For a new server, or to start again with the same one.
  void begin(TimePoint now, std::uint32_t beats) {
    beats_seen_ = beats;
    missed_ = 0;
    stopped_ = false;
    next_check_ = now + kCheckPeriod;
  }
  TimePoint next_check() const { return next_check_; }
  // False: the heartbeat has ceased. `max_heartbeat_gap`: what the server wrote, which may be any number; 0: it has no
  // heartbeat.
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
  int missed_ = 0;  // checks since the last beat
  bool stopped_ = false;
  TimePoint next_check_{};
};

}  // namespace ctn::runtime
