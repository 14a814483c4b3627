// How long the shortest way of the robot to its goal is, past walls and blocks but not past what moves: what the BARN
// score compares with.
//
// The robot counts as a disc as wide as it is, whose centre goes through a grid of 0.1 m; then corners are cut where
// the straight line has room. So the length is good to a cell or two.
//
// Units: metres. Thread safety: a pure function.
#pragma once

#include <optional>

#include "world/world_file.h"

namespace ctn::navigation::run {

// Nothing for a world without a goal, or where there is no way that is wide enough.
std::optional<double> shortest_way(const world::WorldFile& world);

}  // namespace ctn::navigation::run
