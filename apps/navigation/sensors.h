// What the robot's laser and wheels report: the values that pass from a world, or a real robot, to the nodes.
//
// Stamps are nanoseconds since the world began, as everywhere in Catan: whole numbers, so that equal instants are equal
// stamps, and the age of a value needs no conversion where the scheduler's records are read beside it.
//
// Ranges are single precision: the laser errs by a centimetre, and a scan is half as large. Infinity is nothing hit; so
// no range that was measured can be mistaken for it, and std::min() with a limit is how far the beam is free.
//
// Units: metres, radians, nanoseconds. Thread safety: values.
#pragma once

#include <chrono>
#include <cstddef>
#include <numbers>
#include <vector>

#include "geometry.h"

namespace ctn::navigation {

struct Scan {
  std::chrono::nanoseconds stamp{};
  double field = std::numbers::pi;  // angle between the first and the last beam
  double max_range = 30.0;
  std::vector<float> ranges;  // from the right to the left, the heading in the middle; infinite: nothing in max_range

  // The direction of a beam, as seen from the robot.
  double angle(std::size_t beam) const {
    const auto last = static_cast<double>(ranges.size() - 1);
    return last > 0.0 ? field * (static_cast<double>(beam) / last - 0.5) : 0.0;
  }
};

struct Odometry {
  std::chrono::nanoseconds stamp{};
  Pose pose;          // in the odometry's frame, which drifts
  Velocity velocity;  // mean since the last one
};

}  // namespace ctn::navigation
