// A run in real time: the nodes in a session, the world in a thread of its own.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "catan/result.h"
#include "run/detector_chain.h"
#include "run/options.h"
#include "run/outcome.h"
#include "world/world_file.h"

namespace ctn::navigation::run {

// What goes on outside while it runs; may be left empty.
struct LiveWatch {
  std::function<int()> signal;  // that is to end it early; 0: none
  std::function<void(const Progress&)> show;
  std::function<void(const std::string&)> notice;  // of the session
};

// `detector`: as the options ask for, null where they ask for none. Errors: as Session::open(), start() and stop();
// pictures that cannot be written.
Result<Outcome> run_live(const Options& options, const world::WorldFile& world,
                         const std::shared_ptr<DetectorChain>& detector, const LiveWatch& watch);

}  // namespace ctn::navigation::run
