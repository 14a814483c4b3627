// How often a controller may be woken before its timer. Every program that can end a run can wake it, and a controller
// pre-empts everything: a program that does nothing else must not be able to keep a CPU busy that way. Ordinary use
// stays far below.
//
// A token bucket of kBurst wakes that gains one every kRefill. When it is empty the controller ignores wakes for
// kPause, or until its next timer if that is sooner. Pure. Thread safety: one owner; ignored_wakes() from any thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/time.h"

namespace ctn::runtime {

class WakeBudget {
 public:
  static constexpr std::int64_t kBurst = 256;
  static constexpr Nanos kRefill = std::chrono::microseconds{100};
  static constexpr Nanos kPause = std::chrono::milliseconds{1};

  // Called before waiting for a wake, or acting on one at once. False: ignore wakes until kPause has passed.
  bool take(TimePoint now) {
    const std::int64_t earned = std::max<std::int64_t>((now - filled_) / kRefill, 0);
    filled_ += earned * kRefill;
    left_ = std::min(left_ + earned, kBurst);
    if (left_ > 0) {
      --left_;
      return true;
    }
    ignored_wakes_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  // What was taken was not used: a timer came instead.
  void refund() { left_ = std::min(left_ + 1, kBurst); }

  // How often it ignored wakes.
  std::uint64_t ignored_wakes() const { return ignored_wakes_.load(std::memory_order_relaxed); }

 private:
  std::int64_t left_ = kBurst;
  TimePoint filled_{};
  std::atomic<std::uint64_t> ignored_wakes_{0};
};

}  // namespace ctn::runtime
