// Adjusts the robot's past poses so that they agree best with what was measured between them.
//
// Least squares over all poses but the first, which stays: Gauss-Newton steps, each a sparse linear system whose size
// is the number of poses (Grisetti et al., "A Tutorial on Graph-Based SLAM", 2010). Each measurement counts as much as
// its information says, direction by direction.
//
// A measurement may be doubtful, as one is that says that the robot is back where it was: places look alike. Those are
// weighed by a Geman-McClure kernel, which leaves out what contradicts the rest. The kernel is made narrow step by step
// (graduated non-convexity: Yang, Antonante, Tzoumas and Carlone, "Graduated Non-Convexity for Robust Spatial
// Perception", RA-L 2020), so that the result does not depend on where the poses begin.
//
// Units: metres, radians. Thread safety: no state.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry.h"
#include "pose_matrix.h"

namespace ctn::navigation {

// The squared Mahalanobis distance that one in a thousand true measurements of a pose exceeds: the 99.9th percentile of
// the chi-square distribution with three degrees of freedom.
inline constexpr double kOneInThousand = 16.27;

// `to` was measured to be at `measured`, as seen from `from`.
struct Constraint {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose measured;
  PoseMatrix information;  // along the axes of `from`; positive definite
  bool doubtful = false;
  double trust = 1.0;  // of a doubtful one: what relax() weighs it by, 0 to 1
};

struct Relaxed {
  double error = 0.0;  // the sum of weighted squared errors that is left
  std::size_t steps = 0;
};

// Each pose must be reached from the first by constraints that are not doubtful. Sets their trust.
Relaxed relax(std::vector<Pose>& poses, std::vector<Constraint>& constraints);

// How uncertain it is where pose `to` is as seen from pose `from`, by all constraints, each by its trust: a covariance
// along the axes of `from`. Precondition: from != to.
PoseMatrix covariance_between(const std::vector<Pose>& poses, const std::vector<Constraint>& constraints,
                              std::size_t from, std::size_t to);

}  // namespace ctn::navigation
