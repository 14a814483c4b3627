// A flat of straight walls with a robot in it, for tests and benchmarks of the nodes: exact ray casting and contacts,
// odometry that drifts as ordered.
//
// Units: metres, radians, seconds. Thread safety: one thread an object.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "geometry.h"
#include "nodes/testing/plant.h"
#include "robot.h"
#include "sensors.h"

namespace ctn::navigation::testing {

struct Wall {
  Point from;
  Point to;
};

struct Errors {
  double range = 0.0;       // standard deviation of a beam
  double way = 0.0;         // odometry: share of the way that is counted too much
  double turn = 0.0;        // likewise of turns
  double turn_noise = 0.0;  // standard deviation of the heading's error after a second of driving
};

class AnalyticWorld final : public Plant {
 public:
  AnalyticWorld(std::vector<Wall> walls, const Pose& start, const Errors& errors = {}, std::uint64_t seed = 1)
      : walls_(std::move(walls)), errors_(errors), random_(seed), truth_(start) {
    odometry_.pose = start;
  }

  // The base takes up the velocity as fast as it can and keeps it.
  void advance(double seconds, const Velocity& wanted) override {
    constexpr std::chrono::milliseconds kStep(5);
    const double step = std::chrono::duration<double>(kStep).count();
    const int steps = static_cast<int>(std::lround(seconds / step));
    for (int i = 0; i < steps; ++i) {
      constexpr RobotLimits kLimits;
      const double speed_up = kLimits.acceleration * step;
      const double turn_up = kLimits.turn_acceleration * step;
      velocity_.linear += std::clamp(wanted.linear - velocity_.linear, -speed_up, speed_up);
      velocity_.angular += std::clamp(wanted.angular - velocity_.angular, -turn_up, turn_up);
      const double way = velocity_.linear * step;
      const double turn = velocity_.angular * step;
      truth_ = transformed(truth_, Pose{way, 0.0, turn});
      const double noise = way == 0.0 ? 0.0 : errors_.turn_noise * std::sqrt(step) * normal_(random_);
      odometry_.pose =
          transformed(odometry_.pose, Pose{way * (1.0 + errors_.way), 0.0, turn * (1.0 + errors_.turn) + noise});
      driven_ += std::abs(way);
      now_ += kStep;
      touched_ = touched_ || touches();
    }
    odometry_.stamp = now_;
    odometry_.velocity = velocity_;
  }

  Scan scan() override {
    Scan scan;
    scan.stamp = now_;
    scan.ranges.resize(721);
    for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      const double range = cast(truth_.heading + scan.angle(beam));
      const double noisy = range >= kMaxRange ? kNothing : range + errors_.range * normal_(random_);
      scan.ranges[beam] = static_cast<float>(noisy);
    }
    return scan;
  }

  Odometry odometry() override { return odometry_; }
  const Pose& truth() const { return truth_; }
  std::chrono::nanoseconds now() const override { return now_; }
  double driven() const { return driven_; }
  bool touched() const { return touched_; }  // ever
  std::vector<Wall>& walls() { return walls_; }

  // Of a ray from the robot in a direction of the world; kMaxRange: nothing is hit.
  double cast(double direction) const {
    const double dx = std::cos(direction);
    const double dy = std::sin(direction);
    double nearest = kMaxRange;
    for (const Wall& wall : walls_) {
      const double wx = wall.to.x - wall.from.x;
      const double wy = wall.to.y - wall.from.y;
      const double across = dx * wy - dy * wx;
      if (std::abs(across) < 1e-12) continue;
      const double ox = wall.from.x - truth_.x;
      const double oy = wall.from.y - truth_.y;
      const double range = (ox * wy - oy * wx) / across;
      const double along = (ox * dy - oy * dx) / across;
      if (range > 0.0 && range < nearest && along >= 0.0 && along <= 1.0) nearest = range;
    }
    return nearest;
  }

 private:
  static constexpr double kMaxRange = 30.0;  // as Scan::max_range
  static constexpr double kNothing = std::numeric_limits<double>::infinity();

  // Whether a wall crosses the robot's square.
  bool touches() const {
    const Pose to_robot = inverse(truth_);
    return std::any_of(walls_.begin(), walls_.end(), [&](const Wall& wall) {
      const Point from = transformed(to_robot, wall.from);
      const Point to = transformed(to_robot, wall.to);
      double enter = 0.0;
      double leave = 1.0;
      return clip(from.x, to.x, enter, leave) && clip(from.y, to.y, enter, leave) && enter <= leave;
    });
  }

  // The part of a line whose coordinate is inside the robot; false: none.
  static bool clip(double from, double to, double& enter, double& leave) {
    const double way = to - from;
    if (std::abs(way) < 1e-12) return std::abs(from) <= kInnerRadius;
    const double a = (-kInnerRadius - from) / way;
    const double b = (kInnerRadius - from) / way;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
    return enter <= leave;
  }

  std::vector<Wall> walls_;
  Errors errors_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Pose truth_;
  Velocity velocity_;
  Odometry odometry_;
  std::chrono::nanoseconds now_{};
  double driven_ = 0.0;
  bool touched_ = false;
};

inline void add_box(std::vector<Wall>& walls, double left, double bottom, double right, double top) {
  walls.push_back({{left, bottom}, {right, bottom}});
  walls.push_back({{right, bottom}, {right, top}});
  walls.push_back({{right, top}, {left, top}});
  walls.push_back({{left, top}, {left, bottom}});
}

// Two rooms of 5 m x 6 m, with a doorway of 1.4 m between them and a pillar in the right one.
inline std::vector<Wall> two_rooms() {
  std::vector<Wall> walls;
  add_box(walls, 0.0, 0.0, 10.0, 6.0);
  walls.push_back({{5.0, 0.0}, {5.0, 2.3}});
  walls.push_back({{5.0, 3.7}, {5.0, 6.0}});
  add_box(walls, 7.4, 2.6, 7.9, 3.1);
  return walls;
}

// An office floor of 46 m x 26 m: a corridor round a solid block and a row of rooms on each long side.
inline std::vector<Wall> office() {
  std::vector<Wall> walls;
  add_box(walls, 0.0, 0.0, 46.0, 26.0);
  add_box(walls, 10.0, 10.5, 21.0, 15.5);
  add_box(walls, 25.0, 10.5, 36.0, 15.5);
  constexpr double kRoom = 46.0 / 6.0;
  for (int i = 0; i < 6; ++i) {
    const double left = i * kRoom;
    for (const double y : {8.0, 18.0}) {
      walls.push_back({{left, y}, {left + 3.0, y}});
      walls.push_back({{left + 4.5, y}, {left + kRoom, y}});
    }
    if (i == 0) continue;
    walls.push_back({{left, 0.0}, {left, 8.0}});
    walls.push_back({{left, 18.0}, {left, 26.0}});
  }
  return walls;
}

}  // namespace ctn::navigation::testing
