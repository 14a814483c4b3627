// The plain values that the navigation app's world and nodes exchange, and the geometry of poses.
//
// Units: metres, radians, seconds. Headings are anticlockwise from the x axis. Beam 0 of a scan points to the robot's
// right, the last one to its left. Thread safety: values.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace ctn::navigation {

struct Point {
  double x = 0.0;
  double y = 0.0;
  bool operator==(const Point&) const = default;
};

struct Pose {
  double x = 0.0;
  double y = 0.0;
  double heading = 0.0;
  bool operator==(const Pose&) const = default;
};

struct Velocity {
  double linear = 0.0;   // m/s, forwards
  double angular = 0.0;  // rad/s, anticlockwise
  bool operator==(const Velocity&) const = default;
};

struct Scan {
  static constexpr std::size_t kBeams = 721;
  static constexpr double kFieldOfView = std::numbers::pi;
  static constexpr double kMaxRange = 30.0;

  double stamp = 0.0;
  std::array<double, kBeams> ranges{};  // kMaxRange or more: nothing was hit
};

struct Odometry {
  double stamp = 0.0;
  Pose pose;  // in the odometry's frame, which drifts
  Velocity velocity;
};

// The robot: a square whose centre is the laser and the axis of its wheels.
inline constexpr double kRobotSide = 0.56;
inline constexpr double kInnerRadius = kRobotSide / 2.0;  // what is nearer touches the robot
inline constexpr double kOuterRadius =
    kRobotSide / 2.0 * std::numbers::sqrt2;  // what is farther leaves it free to turn
inline constexpr double kMaxSpeed = 0.75;

// What a run did, counted. Its cost in virtual time is computed from this (cost.h).
struct Work {
  std::uint64_t beams = 0;       // of scans that were read or filtered
  std::uint64_t cells = 0;       // of grids that were written or read one after the other
  std::uint64_t candidates = 0;  // points of scans, or of the robot's outline, that were looked up in a grid
  std::uint64_t expanded = 0;    // nodes of a graph search
  bool operator==(const Work&) const = default;
};

// The angle in (-pi, pi].
inline double wrapped(double angle) {
  const double turn = 2.0 * std::numbers::pi;
  const double rest = std::remainder(angle, turn);
  return rest <= -std::numbers::pi ? rest + turn : rest;
}

// The direction of a beam, as seen from the robot.
inline double beam_angle(std::size_t beam) {
  return Scan::kFieldOfView * (static_cast<double>(beam) / static_cast<double>(Scan::kBeams - 1) - 0.5);
}

// `point`, given in the frame that `frame` is the pose of, in the frame that `frame` is given in.
inline Point transformed(const Pose& frame, const Point& point) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  return {frame.x + c * point.x - s * point.y, frame.y + s * point.x + c * point.y};
}

inline Pose transformed(const Pose& frame, const Pose& pose) {
  const Point at = transformed(frame, Point{pose.x, pose.y});
  return {at.x, at.y, wrapped(frame.heading + pose.heading)};
}

// `frame` as seen from itself is the origin: transformed(inverse(frame), frame) is {0, 0, 0}.
inline Pose inverse(const Pose& frame) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  return {-c * frame.x - s * frame.y, s * frame.x - c * frame.y, wrapped(-frame.heading)};
}

// `to` as seen from `from`.
inline Pose between(const Pose& from, const Pose& to) { return transformed(inverse(from), to); }

inline double distance(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y); }
inline Point position(const Pose& pose) { return {pose.x, pose.y}; }

}  // namespace ctn::navigation
