// The case study's robot: a square with differential drive, whose centre is the laser and the axis of its wheels.
//
// Units: metres, m/s, rad/s, m/s^2, rad/s^2. Thread safety: constants.
#pragma once

#include <numbers>

namespace ctn::navigation {

inline constexpr double kRobotSide = 0.56;
inline constexpr double kInnerRadius = kRobotSide / 2.0;  // what is nearer touches the robot
inline constexpr double kOuterRadius =
    kRobotSide / 2.0 * std::numbers::sqrt2;  // what is farther leaves it free to turn

// What the base can do. The speed is the case study's; turning and accelerations are those of a small robot of its
// kind.
struct RobotLimits {
  double speed = 0.75;
  double turn_rate = 1.5;
  double acceleration = 1.0;  // also of braking
  double turn_acceleration = 3.0;
};

// Errors of what the wheels count, which add up: standard deviations after 1 m or 1 rad. They grow with the square root
// of the way or turn. The world draws them, and localization weighs odometry by them.
struct OdometryNoise {
  double distance_per_metre = 0.02;
  double turn_per_radian = 0.03;
  double turn_per_metre = 0.01;
};

}  // namespace ctn::navigation
