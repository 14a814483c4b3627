// Whether a matrix can be a covariance.
//
// Thread safety: no state.
#pragma once

#include <Eigen/Core>

namespace ctn::vr::testing {

// The smallest eigenvalue of a symmetric matrix over its largest one; not a number if the matrix is not finite or not
// symmetric. Not below 0, but for rounding, if it is a covariance.
double relative_smallest_eigenvalue(const Eigen::MatrixXd& matrix);

}  // namespace ctn::vr::testing
