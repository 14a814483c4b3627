// A run in virtual time: the nodes under a simulation, the world as the plant that it drives.
//
// Thread safety: one thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "catan/result.h"
#include "run/detector_chain.h"
#include "run/options.h"
#include "run/outcome.h"
#include "world/world_file.h"

namespace ctn::navigation::run {

// What goes on outside while it runs; may be left empty.
struct Watch {
  std::function<int()> signal;  // that is to end it early; 0: none
  std::function<void(const Progress&)> show;
  std::chrono::nanoseconds step  // of virtual time; changes nothing in the outcome
      = std::chrono::milliseconds(500);
};

// `detector`: as the options ask for, null where they ask for none. Errors: as Simulation::open(); pictures that cannot
// be written.
Result<Outcome> run_virtually(const Options& options, const world::WorldFile& world,
                              const std::shared_ptr<DetectorChain>& detector, const Watch& watch);

}  // namespace ctn::navigation::run
