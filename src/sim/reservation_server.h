// The server behind a reservation of CPU time: a thread may run for `runtime` in each `period`, and among threads with
// reservations the one whose deadline comes first runs. The constant-bandwidth server of Abeni and Buttazzo (1998) in
// its hard form, as Linux's SCHED_DEADLINE has it: a thread whose budget is spent waits until the end of its period,
// even where the CPU is idle. A pure state machine: it is told the time and what happened.
//
// Units: Nanos, TimePoint. Thread safety: none; one owner.
#pragma once

#include <cassert>

#include "base/time.h"

namespace ctn::sim {

class ReservationServer {
 public:
  // Preconditions: 0 < runtime <= period.
  ReservationServer(Nanos runtime, Nanos period) : runtime_(runtime), period_(period) {
    assert(runtime_ > Nanos{0} && runtime_ <= period_);
  }

  // The thread wants to run. What it has left of an earlier period it may use by its deadline only as far as that is no
  // more than its bandwidth; else a new period begins.
  void wake(TimePoint now) {
    if (throttled_) return;
    if (deadline_ <= now || exceeds_bandwidth(now)) {
      budget_ = runtime_;
      deadline_ = now + period_;
    }
  }

  // It has run for so long; whether its budget is spent, and it must wait until `replenished_at()`. Precondition: it
  // may run.
  bool ran(Nanos time) {
    budget_ -= time;
    throttled_ = budget_ <= Nanos{0};
    return throttled_;
  }

  // The end of the period has come, where it waits for that. What it ran too long is taken off.
  void replenish(TimePoint now) {
    if (!throttled_ || now < deadline_) return;
    while (budget_ <= Nanos{0}) {
      budget_ += runtime_;
      deadline_ += period_;
    }
    throttled_ = false;
    if (deadline_ <= now) {
      budget_ = runtime_;
      deadline_ = now + period_;
    }
  }

  bool may_run() const { return !throttled_; }
  Nanos budget() const { return budget_; }
  TimePoint deadline() const { return deadline_; }        // its rank: the earliest first
  TimePoint replenished_at() const { return deadline_; }  // where it may not run

 private:
  // budget / (deadline - now) > runtime / period.
  bool exceeds_bandwidth(TimePoint now) const {
    const auto left = static_cast<double>((deadline_ - now).count());
    return static_cast<double>(budget_.count()) * static_cast<double>(period_.count()) >
           left * static_cast<double>(runtime_.count());
  }

  Nanos runtime_;
  Nanos period_;
  Nanos budget_{0};
  TimePoint deadline_{};
  bool throttled_ = false;
};

}  // namespace ctn::sim
