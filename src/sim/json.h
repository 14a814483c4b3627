// Outcomes as JSON (docs/sim-schema.md).
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/outcome.h"

namespace ctn::sim {

struct Seeded {
  std::uint64_t seed = 0;
  Outcome outcome;
};

// Of one app, scheduler and machine; not empty. One line a key at the top, ends in a newline.
std::string to_json(const std::vector<Seeded>& runs, int cores);

}  // namespace ctn::sim
