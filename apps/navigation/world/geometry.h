// Points, poses and angles in the plane.
//
// Units: metres, radians, counter-clockwise from the x axis. Thread safety: plain values.
#pragma once

#include <cmath>
#include <numbers>

namespace ctn::navigation::world {

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

struct Box {
  Point low;
  Point high;

  double width() const { return high.x - low.x; }
  double height() const { return high.y - low.y; }
  bool contains(Point p) const { return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y; }
  friend bool operator==(const Box&, const Box&) = default;
};

// Headings are not wrapped.
struct Pose {
  double x = 0.0;
  double y = 0.0;
  double heading = 0.0;

  Point point() const { return {x, y}; }
  friend bool operator==(const Pose&, const Pose&) = default;
};

// The same angle in [-pi, pi).
inline double wrapped(double angle) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle - kTurn * std::floor((angle + std::numbers::pi) / kTurn);
}

// The exact pose of a robot that has driven `length` along an arc on which it turned by `turn`.
inline Pose along_arc(const Pose& from, double length, double turn) {
  const double half = turn / 2.0;
  const double chord = length * (std::abs(half) < 1e-4 ? 1.0 - half * half / 6.0 : std::sin(half) / half);
  const double direction = from.heading + half;
  return {from.x + chord * std::cos(direction), from.y + chord * std::sin(direction), from.heading + turn};
}

}  // namespace ctn::navigation::world
