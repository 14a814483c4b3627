#include "vio/testing/covariance.h"

#include <limits>

#include <Eigen/Eigenvalues>

namespace ctn::vr::testing {

double relative_smallest_eigenvalue(const Eigen::MatrixXd& matrix) {
  if (!matrix.allFinite() || matrix != matrix.transpose()) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() / solver.eigenvalues().maxCoeff();
}

}  // namespace ctn::vr::testing
