// When a program that has no server tries to reach one again: at once when it has just lost it, ten times a second
// where no server answers, and less and less often, down to every five seconds, where one answers but refuses. A server
// that it was with before is asked sooner at first: it refuses because it has not noticed yet that the program was
// away.
//
// Pure. Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <algorithm>

#include "base/time.h"

namespace ctn::runtime {

class Redial {
 public:
  static constexpr Nanos kUsual = std::chrono::milliseconds{100};
  static constexpr Nanos kMinDelay = std::chrono::milliseconds{20};
  static constexpr Nanos kMaxDelay = std::chrono::seconds{5};

  // kNever: not now.
  TimePoint due() const { return due_; }

  void at_once(TimePoint now) {
    due_ = now;
    refused_for_ = Nanos{0};
  }
  // Stops trying: there is a server, or its return is noticed in another way.
  void not_now() {
    due_ = kNever;
    refused_for_ = Nanos{0};
  }
  // No server was there, or the answer did not come.
  void unanswered(TimePoint now) {
    due_ = now + kUsual;
    refused_for_ = Nanos{0};
  }
  // `known`: by the server that it was with before.
  void refused(TimePoint now, bool known) {
    const Nanos first = known ? kMinDelay : kUsual;
    refused_for_ = refused_for_ == Nanos{0} ? first : std::min(2 * refused_for_, kMaxDelay);
    due_ = now + refused_for_;
  }

 private:
  TimePoint due_ = kNever;
  Nanos refused_for_{0};  // between the last two tries; 0: it was not refused
};

}  // namespace ctn::runtime
