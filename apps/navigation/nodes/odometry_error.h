// How far odometry may be off since some instant, by the noise of the robot's wheels (robot.h).
//
// The covariance of the pose, as seen from where the robot was then, is propagated from reading to reading, as in an
// extended Kalman filter: an error of the heading moves all that is driven after it.
//
// Units: metres, radians. Thread safety: one thread an object.
#pragma once

#include <cmath>

#include "geometry.h"
#include "pose_matrix.h"
#include "robot.h"

namespace ctn::navigation {

class OdometryError {
 public:
  // Forgets what was; errors count from this pose of the odometry on.
  void start(const Pose& odometry) {
    start_ = odometry;
    seen_ = {};
    covariance_ = {};
  }

  // The next reading.
  void follow(const Pose& odometry) {
    const Pose now = between(start_, odometry);
    const double dx = now.x - seen_.x;
    const double dy = now.y - seen_.y;
    const double way = std::hypot(dx, dy);
    const double turn = std::abs(wrapped(now.heading - seen_.heading));
    PoseMatrix& p = covariance_;
    p.xx += -2.0 * dy * p.xh + dy * dy * p.hh;
    p.xy += dx * p.xh - dy * p.yh - dx * dy * p.hh;
    p.yy += 2.0 * dx * p.yh + dx * dx * p.hh;
    p.xh -= dy * p.hh;
    p.yh += dx * p.hh;
    constexpr OdometryNoise kNoise;
    if (way > 0.0) {
      const double per_metre = kNoise.distance_per_metre * kNoise.distance_per_metre / way;
      p.xx += per_metre * dx * dx;
      p.xy += per_metre * dx * dy;
      p.yy += per_metre * dy * dy;
    }
    p.hh +=
        kNoise.turn_per_radian * kNoise.turn_per_radian * turn + kNoise.turn_per_metre * kNoise.turn_per_metre * way;
    seen_ = now;
  }

  // Of the last reading, as seen from the start; positive definite even if the robot has not moved.
  PoseMatrix covariance() const { return covariance_ + covariance_of(kFloor, kFloor, kFloor); }

 private:
  static constexpr double kFloor = 0.001;  // metres and radians: nothing is known better

  Pose start_;
  Pose seen_;
  PoseMatrix covariance_;
};

}  // namespace ctn::navigation
