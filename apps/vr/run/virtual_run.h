// A run in virtual time: the nodes under a simulation, the headset as the plant.
//
// Thread safety: one thread.
#pragma once

#include <chrono>
#include <functional>

#include "catan/result.h"
#include "run/findings.h"
#include "run/options.h"
#include "run/outcome.h"

namespace ctn::vr::run {

// What goes on outside while it runs; may be left empty.
struct Watch {
  std::function<int()> signal;  // that is to end it early; 0: none
  std::function<void(std::chrono::nanoseconds at)> show;
  std::function<void(const std::string&)> notice;  // of a session
  std::chrono::nanoseconds step                    // of virtual time; changes nothing in the outcome
      = std::chrono::milliseconds(500);

  // Whether it is to end early.
  std::function<bool()> ends() const {
    return [this] { return signal && signal() != 0; };
  }
};

// `options.app_file` is set. Errors: as Simulation::open(), Surroundings::make() and drawn_exposures(); pictures that
// cannot be written.
Result<Outcome> run_virtually(const Options& options, const Watch& watch);

// Of the run's seed: when its clocks tick first, and how far each is off, in virtual time. The exposures of a data set
// are at its pictures' time stamps.
struct DrawnClocks {
  Clock samples;
  Clock display;
  Clock exposures;
};
DrawnClocks clocks_of(const Options& options);
// When they tick in life, since the session's start. There IMU is woken by the session, whose timers begin a period
// after the start, and the other clocks' first ticks count from the first sample.
DrawnClocks clocks_as_in_life(const Options& options);

}  // namespace ctn::vr::run
