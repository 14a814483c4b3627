// How often a controller lets itself be woken out of turn. Whoever can end a run can wake it, and a controller outranks
// everything: a program that does nothing else must not keep a CPU busy with it. Ordinary use never comes near.
//
// A bucket of kBurst wakes that fills up by one every kRefill; when it is empty the controller is deaf for kDeaf, or
// until its next timer if that is sooner. Pure. Thread safety: one owner; floods() from any thread.
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
  static constexpr Nanos kDeaf = std::chrono::milliseconds{1};

  // A wake is about to be waited for, or to be followed at once. False: be deaf now.
  bool take(TimePoint now) {
    const std::int64_t earned = std::max<std::int64_t>((now - filled_) / kRefill, 0);
    filled_ += earned * kRefill;
    left_ = std::min(left_ + earned, kBurst);
    if (left_ > 0) {
      --left_;
      return true;
    }
    floods_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  // What was taken was not used: a timer came instead.
  void give_back() { left_ = std::min(left_ + 1, kBurst); }

  // How often it was deaf.
  std::uint64_t floods() const { return floods_.load(std::memory_order_relaxed); }

 private:
  std::int64_t left_ = kBurst;
  TimePoint filled_{};
  std::atomic<std::uint64_t> floods_{0};
};

}  // namespace ctn::runtime
