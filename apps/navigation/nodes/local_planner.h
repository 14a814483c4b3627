// The LP node: the velocity that brings the robot nearer to the carrot, and into nothing that the local map shows.
//
// The target is the carrot or, where something is between, a point of the way round (detour.h). Then the dynamic window
// (Fox, Burgard and Thrun, "The dynamic window approach to collision avoidance", 1997): for each velocity that the base
// can reach within a moment, the robot's outline is moved over the map along an arc. A velocity is allowed if the robot
// could still brake before it touches anything. Of these, the one is chosen that ends nearest to the target, pointing
// at it, with room at its sides. If no other than standing still is allowed, the robot may back up.
//
// Where something moves nearby, the best of them that is safe from it is chosen (foresight.h): so the robot slows down,
// waits for it to pass, passes behind it, or gets out of its way, also if it was to stand still. If none is safe, it is
// the one with which contact can be put off longest. A robot that has waited for long takes less account of what may
// turn back.
//
// Where the base does not do what it is told, something holds it that the map does not show (getting_free.h).
//
// How fast the base is follows from what it was told, corrected by what the wheels count: over 20 ms that is wrong by
// 0.1 m/s, by which the way to stop would change from one run to the next by a tenth of a metre.
//
// Predictions begin at the instants of scan and odometry. The robot counts on keeping a velocity for LP's nominal
// period, and on reacting then: however seldom maps really come, which LP is not told (docs/decisions/0075).
//
// Units: metres, radians, seconds. Thread safety: one thread an object.
#pragma once

#include <chrono>
#include <optional>

#include "detour.h"
#include "foresight.h"
#include "geometry.h"
#include "getting_free.h"
#include "local_mapper.h"
#include "navigation_command.h"
#include "robot.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

class LocalPlanner {
 public:
  static constexpr RobotLimits kLimits{};
  static constexpr double kReaction = 0.1;  // seconds until the robot can react to what is new: LP's nominal period
  static constexpr double kMargin = 0.09;   // around the robot

  struct Result {
    Velocity velocity;
    Detour::Kind way = Detour::Kind::kStraight;
    Foresight::Level safety = Foresight::Level::kSafe;
    Work work;
  };
  Result run(const LocalMap& map, const Odometry& odometry, const Command& command);

 private:
  Result plan(const LocalMap& map, const Odometry& odometry, const Command& command);
  Odometry smoothed(const Odometry& counted);
  void wait(const LocalMap& map, const Odometry& odometry, bool wants_to_go);

  std::chrono::nanoseconds stamp_{};  // of the last map
  double waited_ = 0.0;               // seconds
  GettingFree getting_free_;
  // Of the run before: what the wheels had counted until then, how fast the base was, and what it was told.
  std::chrono::nanoseconds counted_at_{};
  std::optional<Velocity> driven_;
  Velocity wanted_;
};

}  // namespace ctn::navigation
