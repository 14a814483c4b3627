// When to wake a thread that makes a picture for each tick of a display, as the compositors of XR runtimes do: as late
// as it can be, so that what it reads is new.
//
// It wakes its thread by a *lead* before each tick. What was too late for its deadline makes the lead longer at once;
// what was done with time to spare makes it a little shorter each time; what was done just in time leaves it as it is.
// So it comes close to the deadline slowly, and backs off fast.
//
// Units: nanoseconds. Thread safety: one thread.
#pragma once

#include <chrono>

#include "run/clock.h"

namespace ctn::vr::run {

class Pacer {
 public:
  // `look`: how often due() is asked.
  Pacer(const Clock& display, std::chrono::nanoseconds look);

  // Whether to wake now, which it says once for each tick.
  bool due(std::chrono::nanoseconds now);
  // The tick that was meant last.
  std::chrono::nanoseconds tick() const { return tick_; }

  // How long before its deadline something that was woken for was done; below 0: it was too late.
  void done(std::chrono::nanoseconds spare);

  std::chrono::nanoseconds lead() const { return lead_; }

 private:
  Clock display_;
  std::chrono::nanoseconds look_;
  std::chrono::nanoseconds lead_;
  std::chrono::nanoseconds tick_;
};

}  // namespace ctn::vr::run
