// Adjusts the robot's past poses so that they agree best with what was measured between them.
//
// Least squares over all poses but the first, which stays: Gauss-Newton steps, each a sparse linear system whose size
// is the number of poses (Grisetti et al., "A Tutorial on Graph-Based SLAM", 2010).
//
// Units: metres, radians. Thread safety: no state.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry.h"

namespace ctn::navigation {

// `to` was measured to be at `measured`, as seen from `from`.
struct Constraint {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose measured;
  double weight = 1.0;  // the inverse of the variance, relative to others
};

// Each pose must be reached by constraints from the first. Returns the sum of weighted squared errors that is left.
double relax(std::vector<Pose>& poses, const std::vector<Constraint>& constraints);

}  // namespace ctn::navigation
