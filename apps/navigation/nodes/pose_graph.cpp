#include "pose_graph.h"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

namespace ctn::navigation {
namespace {

constexpr int kMaxSteps = 10;
constexpr double kSmallStep = 1e-6;
constexpr double kTurnWeight = 10.0;  // a radian counts as much as this squared number of metres does

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

struct Linear {
  Vector3 error;
  Matrix3 by_from;
  Matrix3 by_to;
};

Linear linearise(const Pose& from, const Pose& to, const Pose& measured) {
  const Pose seen = between(from, to);
  const double c = std::cos(from.heading);
  const double s = std::sin(from.heading);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  Linear linear;
  linear.error << seen.x - measured.x, seen.y - measured.y, wrapped(seen.heading - measured.heading);
  linear.by_from << -c, -s, -s * dx + c * dy, s, -c, -c * dx - s * dy, 0.0, 0.0, -1.0;
  linear.by_to << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
  return linear;
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

}  // namespace

double relax(std::vector<Pose>& poses, const std::vector<Constraint>& constraints) {
  const auto error_of = [&] {
    double sum = 0.0;
    for (const Constraint& constraint : constraints) {
      const Vector3 error = linearise(poses[constraint.from], poses[constraint.to], constraint.measured).error;
      sum += constraint.weight * (error[0] * error[0] + error[1] * error[1] + kTurnWeight * error[2] * error[2]);
    }
    return sum;
  };
  if (poses.size() < 2) return error_of();

  const auto size = static_cast<Eigen::Index>(3 * (poses.size() - 1));
  for (int step = 0; step < kMaxSteps; ++step) {
    Triplets triplets;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (const Constraint& constraint : constraints) {
      const Linear linear = linearise(poses[constraint.from], poses[constraint.to], constraint.measured);
      const Matrix3 weight = constraint.weight * Vector3(1.0, 1.0, kTurnWeight).asDiagonal().toDenseMatrix();
      const Matrix3 from_weighted = linear.by_from.transpose() * weight;
      const Matrix3 to_weighted = linear.by_to.transpose() * weight;
      add_block(triplets, constraint.from, constraint.from, from_weighted * linear.by_from);
      add_block(triplets, constraint.from, constraint.to, from_weighted * linear.by_to);
      add_block(triplets, constraint.to, constraint.from, to_weighted * linear.by_from);
      add_block(triplets, constraint.to, constraint.to, to_weighted * linear.by_to);
      const auto add_gradient = [&](std::size_t pose, const Matrix3& weighted) {
        if (pose != 0) gradient.segment<3>(static_cast<Eigen::Index>(3 * (pose - 1))) += weighted * linear.error;
      };
      add_gradient(constraint.from, from_weighted);
      add_gradient(constraint.to, to_weighted);
    }
    Eigen::SparseMatrix<double> hessian(size, size);
    hessian.setFromTriplets(triplets.begin(), triplets.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(hessian);
    if (factors.info() != Eigen::Success) break;
    const Eigen::VectorXd change = factors.solve(-gradient);
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * (i - 1));
      poses[i].x += change[at];
      poses[i].y += change[at + 1];
      poses[i].heading = wrapped(poses[i].heading + change[at + 2]);
    }
    if (change.lpNorm<Eigen::Infinity>() < kSmallStep) break;
  }
  return error_of();
}

}  // namespace ctn::navigation
