// The LP node: the velocity that brings the robot nearer to the carrot, and into no obstacle that the local map shows.
//
// The target is the carrot or, where something is between, a point of the way round (detour.h). Then the dynamic window
// (Fox, Burgard and Thrun, 1997): for each velocity that the base can reach within a moment, the robot's outline is
// moved over the map along an arc. A velocity is allowed if the robot could still brake before it touches anything. Of
// these, the one is chosen that ends nearest to the target, pointing at it, with room at its sides. If no other than
// standing still is allowed, the robot may back up.
//
// Units: metres, radians, seconds. Thread safety: no state.
#pragma once

#include "detour.h"
#include "geometry.h"
#include "local_mapper.h"
#include "navigation_command.h"
#include "robot.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

class LocalPlanner {
 public:
  static constexpr RobotLimits kLimits{};
  static constexpr double kReaction = 0.2;  // seconds that pass before the robot brakes
  static constexpr double kMargin = 0.09;   // around the robot

  struct Result {
    Velocity velocity;
    Detour::Kind way = Detour::Kind::kStraight;
    Work work;
  };
  Result run(const LocalMap& map, const Odometry& odometry, const Command& command) const;
};

}  // namespace ctn::navigation
