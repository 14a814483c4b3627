// Outcomes of simulations as tables for people.
#pragma once

#include <string>
#include <vector>

#include "sim/json.h"

namespace ctn::tool {

// Of one app, scheduler and machine; not empty. Of several runs: each figure's mean over the runs, the greatest of the
// maxima.
std::string sim_text(const std::vector<sim::Seeded>& runs, int cores);

}  // namespace ctn::tool
