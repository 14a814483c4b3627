// Generated worlds: static clutter and a crowd of movers between the start at one end and the goal at the other, in the
// manner of the DynaBARN benchmark. Results over many of them say more about a robot than those on one map.
//
// There is always a way for the robot past the clutter, whatever its heading (checked on a grid of 0.1 m). Movers keep
// to free space and away from the start. Their timetables are in the file, phases included, so they do not depend on a
// run's seed.
//
// Thread safety: a pure function.
#pragma once

#include <cstdint>

#include "world_file.h"

namespace ctn::navigation::world {

struct CrowdSpec {
  std::uint64_t seed = 1;
  double density = 0.04;  // the share of the ground that clutter covers; less where there would be no way through
  int movers = 8;         // fewer where there is no room for their paths
  double length = 20.0;   // along the way; at least 8 m
  double width = 12.0;    // at least 4 m
};

WorldFile make_crowd(const CrowdSpec& spec);

}  // namespace ctn::navigation::world
