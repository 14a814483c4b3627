#include "vio/triangulation.h"

#include <algorithm>
#include <cstddef>

#include <Eigen/Cholesky>

namespace ctn::vr {
namespace {

constexpr int kMaxIterations = 8;
constexpr double kMinDistance = 0.1;  // metres
constexpr double kMaxDistance = 40.0;
constexpr double kMaxResidual = 5.0;  // root of the mean square, in standard deviations of the noise

struct Ray {  // a view, as seen from the first camera
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  Eigen::Vector2d point;
};

std::vector<Ray> rays_of(const std::vector<View>& views) {
  std::vector<Ray> rays;
  rays.reserve(views.size());
  for (const View& view : views) {
    const Pose from_first = transformed(inverse(view.world_from_camera), views.front().world_from_camera);
    rays.push_back({from_first.orientation.toRotationMatrix(), from_first.position, view.point});
  }
  return rays;
}

// The inverse distance, if the direction in the first view were exact.
double first_guess(const std::vector<Ray>& rays) {
  double numerator = 0.0;
  double denominator = 0.0;
  for (const Ray& ray : rays) {
    const Eigen::Vector3d turned = ray.rotation * rays.front().point.homogeneous();
    const Eigen::Vector2d constant = turned.head<2>() - ray.point * turned.z();
    const Eigen::Vector2d slope = ray.translation.head<2>() - ray.point * ray.translation.z();
    numerator -= constant.dot(slope);
    denominator += slope.squaredNorm();
  }
  return denominator > 1e-12 ? numerator / denominator : 0.0;
}

struct Equations {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double error = 0.0;  // sum of squares
  bool in_front = true;
};

Equations equations_of(const std::vector<Ray>& rays, const Eigen::Vector3d& unknown) {
  Equations equations;
  for (const Ray& ray : rays) {
    const Eigen::Vector3d seen =
        ray.rotation * Eigen::Vector3d(unknown.x(), unknown.y(), 1.0) + unknown.z() * ray.translation;
    if (!(seen.z() > 1e-3)) {
      equations.in_front = false;
      return equations;
    }
    const Eigen::Vector2d residual = ray.point - seen.hnormalized();
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0, 0.0, -seen.x() / seen.z(), 0.0, 1.0, -seen.y() / seen.z();
    Eigen::Matrix3d by_unknown;
    by_unknown << ray.rotation.leftCols<2>(), ray.translation;
    const Eigen::Matrix<double, 2, 3> jacobian = projection * by_unknown / seen.z();
    equations.matrix += jacobian.transpose() * jacobian;
    equations.right += jacobian.transpose() * residual;
    equations.error += residual.squaredNorm();
  }
  return equations;
}

Eigen::Vector3d step_of(const Equations& equations) {
  // A little is added to the diagonal, so that a distance that the views do not tell stays what it is.
  const Eigen::Matrix3d damped = equations.matrix + 1e-9 * Eigen::Matrix3d::Identity();
  return damped.ldlt().solve(equations.right);
}

double limited(double inverse_distance) { return std::clamp(inverse_distance, 1.0 / kMaxDistance, 1.0 / kMinDistance); }

}  // namespace

Triangulation triangulate(const std::vector<View>& views, double noise) {
  Triangulation result;
  if (views.size() < 2) return result;
  const std::vector<Ray> rays = rays_of(views);
  Eigen::Vector3d unknown;
  unknown << rays.front().point, limited(first_guess(rays));
  Equations equations = equations_of(rays, unknown);
  result.work.observations += 2 * rays.size();
  for (int i = 0; i < kMaxIterations && equations.in_front; ++i) {
    const Eigen::Vector3d wanted = unknown + step_of(equations);
    Eigen::Vector3d moved = wanted;
    moved.z() = limited(wanted.z());
    if (moved.z() != wanted.z()) {
      // The best direction for the distance at the limit.
      const Eigen::Vector2d right =
          equations.right.head<2>() - equations.matrix.block<2, 1>(0, 2) * (moved.z() - unknown.z());
      moved.head<2>() = unknown.head<2>() + equations.matrix.topLeftCorner<2, 2>().ldlt().solve(right);
    }
    const Equations next = equations_of(rays, moved);
    result.work.observations += rays.size();
    if (!next.in_front || !(next.error < equations.error)) break;
    unknown = moved;
    const bool settled = next.error > equations.error * (1.0 - 1e-4);
    equations = next;
    if (settled) break;
  }
  if (!equations.in_front || !unknown.allFinite()) return result;
  if (equations.error > kMaxResidual * kMaxResidual * noise * noise * 2.0 * static_cast<double>(rays.size())) {
    return result;
  }
  const Eigen::Vector3d point = Eigen::Vector3d(unknown.x(), unknown.y(), 1.0) / unknown.z();
  result.point = transformed(views.front().world_from_camera, point);
  return result;
}

}  // namespace ctn::vr
