// How far an estimated trajectory is from the true one, as benchmarks of visual-inertial odometry measure it.
//
// Such odometry cannot know where it started nor which way is north, only which way is up. So before the absolute
// trajectory error (ATE) is taken, the estimate is turned about the vertical and moved, such that the squares of the
// position errors are least: Umeyama's alignment (1991), with the rotation restricted to yaw, as Zhang and Scaramuzza
// (2018) recommend for visual-inertial systems. The relative error compares how far both have come within a
// given time, without any alignment: drift.
//
// Units: metres, radians, seconds. Thread safety: no state.
#pragma once

#include <cstddef>
#include <vector>

#include "sensors.h"

namespace ctn::vr {

struct StampedPose {
  double time = 0.0;
  Pose pose;
};

// Turns by yaw about the vertical, then moves.
struct YawAlignment {
  double yaw = 0.0;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};
Pose aligned(const YawAlignment& alignment, const Pose& pose);

struct TrajectoryError {
  std::size_t poses = 0;       // that have a true one beside them; of 0, there is no error
  double position_rmse = 0.0;  // metres
  double position_max = 0.0;
  double rotation_rmse = 0.0;  // radians
  YawAlignment alignment;      // of the estimate to the truth; relative_error has none
};

// Both by time, ascending. The true pose at the time of an estimated one is interpolated; where the truth does not
// reach it is left out.
TrajectoryError absolute_error(const std::vector<StampedPose>& estimated, const std::vector<StampedPose>& truth);

// Of the motion from each estimated pose to the first one that is at least `seconds` later.
TrajectoryError relative_error(const std::vector<StampedPose>& estimated, const std::vector<StampedPose>& truth,
                               double seconds);

}  // namespace ctn::vr
