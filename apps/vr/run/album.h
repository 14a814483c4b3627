// Pictures of a run, one for each second of it: what the wearer sees at the first tick of that second, beside what is
// true at that instant.
//
// Thread safety: one thread.
#pragma once

#include <vector>

#include "catan/result.h"
#include "run/display.h"
#include "run/options.h"
#include "run/surroundings.h"

namespace ctn::vr::run {

// Makes the folder, and writes `second-0007.png`: left what is seen, right what is true, where that is known. Errors
// (kEnvironment): one cannot be written; as DrawingParts::open().
Status draw_album(const Options& options, const Surroundings& surroundings, const std::vector<Photon>& photons);

}  // namespace ctn::vr::run
