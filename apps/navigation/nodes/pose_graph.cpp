#include "pose_graph.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

namespace ctn::navigation {
namespace {

constexpr std::size_t kMaxSteps = 30;
constexpr double kSmallStep = 1e-4;
constexpr double kNarrower = 2.0;  // the square of the kernel's width, from step to step

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;
using Sparse = Eigen::SparseMatrix<double>;

struct Linear {
  Matrix3 by_from;
  Matrix3 by_to;
};

Pose error_of(const std::vector<Pose>& poses, const Constraint& constraint) {
  const Pose seen = between(poses[constraint.from], poses[constraint.to]);
  const Pose& measured = constraint.measured;
  return {seen.x - measured.x, seen.y - measured.y, wrapped(seen.heading - measured.heading)};
}

// How the pose of `to`, as seen from `from`, changes with both.
Linear linearise(const Pose& from, const Pose& to) {
  const double c = std::cos(from.heading);
  const double s = std::sin(from.heading);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  Linear linear;
  linear.by_from << -c, -s, -s * dx + c * dy, s, -c, -c * dx - s * dy, 0.0, 0.0, -1.0;
  linear.by_to << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
  return linear;
}

Matrix3 to_eigen(const PoseMatrix& m) {
  Matrix3 matrix;
  matrix << m.xx, m.xy, m.xh, m.xy, m.yy, m.yh, m.xh, m.yh, m.hh;
  return matrix;
}

using Triplets = std::vector<Eigen::Triplet<double>>;

void add_block(Triplets& triplets, std::size_t row, std::size_t column, const Matrix3& block) {
  if (row == 0 || column == 0) return;  // the first pose is fixed
  const auto top = static_cast<int>(3 * (row - 1));
  const auto left = static_cast<int>(3 * (column - 1));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) triplets.emplace_back(top + i, left + j, block(i, j));
  }
}

// The normal equations of a Gauss-Newton step.
struct Normal {
  Sparse hessian;
  Eigen::VectorXd gradient;
};

Normal normal_of(const std::vector<Pose>& poses, const std::vector<Constraint>& constraints) {
  const auto size = static_cast<Eigen::Index>(3 * (poses.size() - 1));
  Normal normal{Sparse(size, size), Eigen::VectorXd::Zero(size)};
  Triplets triplets;
  triplets.reserve(36 * constraints.size());
  for (const Constraint& constraint : constraints) {
    const Linear linear = linearise(poses[constraint.from], poses[constraint.to]);
    const Pose off = error_of(poses, constraint);
    const Vector3 error(off.x, off.y, off.heading);
    const Matrix3 weight = constraint.trust * to_eigen(constraint.information);
    const Matrix3 from_weighted = linear.by_from.transpose() * weight;
    const Matrix3 to_weighted = linear.by_to.transpose() * weight;
    add_block(triplets, constraint.from, constraint.from, from_weighted * linear.by_from);
    add_block(triplets, constraint.from, constraint.to, from_weighted * linear.by_to);
    add_block(triplets, constraint.to, constraint.from, to_weighted * linear.by_from);
    add_block(triplets, constraint.to, constraint.to, to_weighted * linear.by_to);
    const auto add_gradient = [&](std::size_t pose, const Matrix3& weighted) {
      if (pose != 0) normal.gradient.segment<3>(static_cast<Eigen::Index>(3 * (pose - 1))) += weighted * error;
    };
    add_gradient(constraint.from, from_weighted);
    add_gradient(constraint.to, to_weighted);
  }
  normal.hessian.setFromTriplets(triplets.begin(), triplets.end());
  return normal;
}

// Weighs doubtful constraints by a kernel whose square is `width` times as wide as it is to be in the end.
void weigh(const std::vector<Pose>& poses, std::vector<Constraint>& constraints, double width) {
  for (Constraint& constraint : constraints) {
    if (!constraint.doubtful) continue;
    const double wide = width * kOneInThousand;
    const double share = wide / (wide + squared(constraint.information, error_of(poses, constraint)));
    constraint.trust = share * share;
  }
}

}  // namespace

Relaxed relax(std::vector<Pose>& poses, std::vector<Constraint>& constraints) {
  double width = 1.0;
  for (const Constraint& constraint : constraints) {
    if (!constraint.doubtful) continue;
    width = std::max(width, 2.0 * squared(constraint.information, error_of(poses, constraint)) / kOneInThousand);
  }
  Relaxed relaxed;
  while (poses.size() > 1 && relaxed.steps < kMaxSteps) {
    weigh(poses, constraints, width);
    ++relaxed.steps;
    const Normal normal = normal_of(poses, constraints);
    const Eigen::SimplicialLDLT<Sparse> factors(normal.hessian);
    if (factors.info() != Eigen::Success) break;
    const Eigen::VectorXd change = factors.solve(-normal.gradient);
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * (i - 1));
      poses[i].x += change[at];
      poses[i].y += change[at + 1];
      poses[i].heading = wrapped(poses[i].heading + change[at + 2]);
    }
    if (width <= 1.0 && change.lpNorm<Eigen::Infinity>() < kSmallStep) break;
    width = std::max(1.0, width / kNarrower);
  }
  for (const Constraint& constraint : constraints) {
    relaxed.error += constraint.trust * squared(constraint.information, error_of(poses, constraint));
  }
  return relaxed;
}

PoseMatrix covariance_between(const std::vector<Pose>& poses, const std::vector<Constraint>& constraints,
                              std::size_t from, std::size_t to) {
  const Linear linear = linearise(poses[from], poses[to]);
  const Normal normal = normal_of(poses, constraints);
  // The columns of the derivative of what is asked for, by all poses; the inverse of the Hessian is their covariance.
  Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(normal.hessian.rows(), 3);
  const auto set = [&derivative](std::size_t pose, const Matrix3& by_pose) {
    if (pose != 0) derivative.middleRows<3>(static_cast<Eigen::Index>(3 * (pose - 1))) = by_pose.transpose();
  };
  set(from, linear.by_from);
  set(to, linear.by_to);
  const Eigen::SimplicialLDLT<Sparse> factors(normal.hessian);
  const Matrix3 covariance = derivative.transpose() * factors.solve(derivative);
  return {covariance(0, 0), covariance(0, 1), covariance(0, 2), covariance(1, 1), covariance(1, 2), covariance(2, 2)};
}

}  // namespace ctn::navigation
