// The scan node: makes a raw scan fit for mapping and matching.
//
// Ranges that are not numbers, negative or too short (the robot itself, dust) count as nothing hit. A median over five
// beams removes single outliers, and leaves edges where they are. Hits are turned into points, each at least kSpacing
// from the one before it, so that a near wall does not outweigh the rest.
//
// Units: metres, radians, nanoseconds. Thread safety: no state.
#pragma once

#include <memory>
#include <vector>

#include "geometry.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

struct CleanScan : Scan {
  Odometry odometry;          // the newest when the scan was taken
  std::vector<Point> points;  // of hits, thinned out, as seen from the robot
};
using SharedScan = std::shared_ptr<const CleanScan>;

class ScanFilter {
 public:
  static constexpr double kMinRange = 0.1;
  static constexpr double kSpacing = 0.03;

  struct Result {
    SharedScan scan;
    Work work;
  };
  Result run(const Scan& raw, const Odometry& odometry) const;
};

}  // namespace ctn::navigation
