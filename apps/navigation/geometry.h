// Points, poses, velocities and boxes in the plane, for the navigation app's world and nodes.
//
// A pose is where a frame lies in another one: the robot in the odometry's frame, or that frame in the map's.
//
// Units: metres, radians, m/s, rad/s. Angles are anticlockwise from the x axis; y is to the left of x.
// Thread safety: values.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace ctn::navigation {

struct Point {
  double x = 0.0;
  double y = 0.0;

  friend bool operator==(const Point&, const Point&) = default;
};

inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(Point a, double by) { return {a.x * by, a.y * by}; }
inline double distance(Point a, Point b) { return std::hypot(a.x - b.x, a.y - b.y); }

struct Segment {
  Point from;
  Point to;

  friend bool operator==(const Segment&, const Segment&) = default;
};

// The distance to the nearest point of the segment.
inline double distance(const Segment& segment, Point point) {
  const Point along = segment.to - segment.from;
  const double square = along.x * along.x + along.y * along.y;
  const Point from = point - segment.from;
  const double share = square > 0.0 ? (from.x * along.x + from.y * along.y) / square : 0.0;
  return distance(point, segment.from + along * std::fmin(1.0, std::fmax(0.0, share)));
}

// Of a closed polygon.
inline std::vector<Segment> sides_of(const std::vector<Point>& corners) {
  std::vector<Segment> sides;
  for (std::size_t i = 0; i < corners.size(); ++i) sides.push_back({corners[i], corners[(i + 1) % corners.size()]});
  return sides;
}

struct Box {
  Point low;
  Point high;

  double width() const { return high.x - low.x; }
  double height() const { return high.y - low.y; }
  bool contains(Point p) const { return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y; }
  friend bool operator==(const Box&, const Box&) = default;
};

// Headings need not be wrapped.
struct Pose {
  double x = 0.0;
  double y = 0.0;
  double heading = 0.0;

  friend bool operator==(const Pose&, const Pose&) = default;
};

inline Point position(const Pose& pose) { return {pose.x, pose.y}; }

struct Velocity {
  double linear = 0.0;   // m/s, forwards
  double angular = 0.0;  // rad/s, anticlockwise

  friend bool operator==(const Velocity&, const Velocity&) = default;
};

inline constexpr double kDegree = std::numbers::pi / 180.0;

// The same angle in (-pi, pi].
inline double wrapped(double angle) {
  const double rest = std::remainder(angle, 2.0 * std::numbers::pi);
  return rest <= -std::numbers::pi ? rest + 2.0 * std::numbers::pi : rest;
}

// `point`, given in the frame that `frame` is the pose of, in the frame that `frame` is given in.
inline Point transformed(const Pose& frame, Point point) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  return {frame.x + c * point.x - s * point.y, frame.y + s * point.x + c * point.y};
}

inline Pose transformed(const Pose& frame, const Pose& pose) {
  const Point at = transformed(frame, position(pose));
  return {at.x, at.y, wrapped(frame.heading + pose.heading)};
}

// transformed(inverse(frame), frame) is {0, 0, 0}.
inline Pose inverse(const Pose& frame) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  return {-c * frame.x - s * frame.y, s * frame.x - c * frame.y, wrapped(-frame.heading)};
}

// `to` as seen from `from`.
inline Pose between(const Pose& from, const Pose& to) { return transformed(inverse(from), to); }

// The exact pose of a robot that has driven `length` along an arc on which it turned by `turn`. Not wrapped.
inline Pose along_arc(const Pose& from, double length, double turn) {
  const double half = turn / 2.0;
  const double chord = length * (std::abs(half) < 1e-4 ? 1.0 - half * half / 6.0 : std::sin(half) / half);
  const double direction = from.heading + half;
  return {from.x + chord * std::cos(direction), from.y + chord * std::sin(direction), from.heading + turn};
}

}  // namespace ctn::navigation
