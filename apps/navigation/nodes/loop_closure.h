// Whether the robot is back at a place that it left long ago, and where exactly: places look alike, and a loop that is
// closed wrongly bends the whole map.
//
// The newest scan is matched against the scans of that time, in a window as wide as the robot is uncertain of where the
// place is. The match is taken if
//   - it fits: most points fall on points of that time,
//   - neither scan saw through what the other one hit (visibility.h), but for what moves,
//   - it is where it may be, by all that was measured on the way: a chi-square test with the covariances of the way and
//     of the match.
// What is left to doubt is in the match's covariance: a corridor says nothing along its axis.
//
// Units: metres, radians. Thread safety: no state.
#pragma once

#include <optional>
#include <vector>

#include "geometry.h"
#include "pose_matrix.h"
#include "scan_filter.h"
#include "work.h"

namespace ctn::navigation {

// What a keyframe saw.
struct Sight {
  Pose pose;
  const CleanScan& scan;
  const std::vector<Point>& still;  // points of the scan, without what moved
};

struct Recognised {
  Pose pose;  // of the robot, relative to the poses of the old sights
  PoseMatrix covariance;
};

// `old`: from one place, the nearest first. `drift`: the covariance of now.pose, if the old poses are taken to be
// right. Both along the axes of the map.
std::optional<Recognised> recognise(const std::vector<Sight>& old, const Sight& now, const PoseMatrix& drift,
                                    Work& work);

}  // namespace ctn::navigation
