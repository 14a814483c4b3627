// A run in real time: the nodes in a session, the display in a thread of its own. Pictures are really drawn, each on a
// screen of its own; those of the camera are drawn before.
//
// Thread safety: one thread.
#pragma once

#include "catan/result.h"
#include "run/options.h"
#include "run/outcome.h"
#include "run/virtual_run.h"

namespace ctn::vr::run {

// A camera that is triggered gives the newest of so many pictures a second, which are there before the run.
inline constexpr double kReadyHz = 60.0;

// `options.app_file` is set. Errors: as Session::open(), start() and stop(); as Surroundings::make(), DrawingParts and
// ready_exposures().
Result<Outcome> run_live(const Options& options, const Watch& watch);

}  // namespace ctn::vr::run
