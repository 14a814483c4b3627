// Pictures of a run, one for each second of it: what the wearer sees at the first tick of that second, beside what is
// true at that instant.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <vector>

#include "catan/result.h"
#include "run/display.h"
#include "run/options.h"
#include "run/surroundings.h"

namespace ctn::vr::run {

// Makes the folder, and writes `second-0007.png`: left what is seen, right what is true, where that is known. Errors
// (kEnvironment): one cannot be written; as DrawingParts::open().
// `ends` is asked before each: where it says so, the rest is left out.
Status draw_album(const Options& options, const Surroundings& surroundings, const std::vector<Photon>& photons,
                  const std::function<bool()>& ends);

}  // namespace ctn::vr::run
