// The app in virtual time: the same nodes and the same world under a simulation, which draws what runs cost from a cost
// file. Pictures and detections are real.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <string>

#include "catan/result.h"
#include "options.h"
#include "outcome.h"

namespace ctn::face_tracking {

// Asked, and told, twice a second of virtual time.
struct Watch {
  std::function<int()> signal;                   // that is to end it early; 0: none
  std::function<void(const std::string&)> show;  // the live line
};

// Errors: as Simulation::open(), Detector::open() and load_footage().
Result<Outcome> run_virtually(const Options& options, const Watch& watch);

}  // namespace ctn::face_tracking
