// A way round what the local map shows between the robot and the path: where LP should head, if not straight to the
// carrot.
//
// The goal is the carrot or, if an obstacle is on it, the first point of the path beyond that is free. If a straight
// way to it is free, it is what LP heads for. Otherwise a wave front spreads from the goal over the free cells of the
// local map (Dijkstra's algorithm, on cells twice as large as the map's) until it reaches the robot; LP heads for the
// farthest point of this way that a straight way leads to. So LP, which by itself goes downhill only, is not caught
// behind an obstacle (Brock and Khatib, "High-speed navigation using the global dynamic window approach", 1999).
//
// Units: metres, in the odometry's frame. Thread safety: no state.
#pragma once

#include "geometry.h"
#include "local_mapper.h"
#include "navigation_command.h"
#include "robot.h"
#include "work.h"

namespace ctn::navigation {

struct Detour {
  enum class Kind {
    kStraight,  // to the goal itself
    kRound,     // by a way round
    kBlocked,   // the local map has no way to the goal; `target` is the carrot
  };
  Kind kind = Kind::kStraight;
  Point target;
  Work work;
};

// `margin`: what the robot's centre should keep from obstacles beyond its inner radius.
Detour find_detour(const LocalMap& map, Point robot, const Command& command, double margin);

}  // namespace ctn::navigation
