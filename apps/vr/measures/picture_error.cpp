#include "measures/picture_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>

#include "lens.h"

namespace ctn::vr::measures {

Pose shown_by_rotation(const Pose& drawn, const Pose& warped) { return {warped.orientation, drawn.position}; }

double rotation_error(const Pose& shown, const Pose& truth) {
  return shown.orientation.angularDistance(truth.orientation) * 180.0 / std::numbers::pi;
}

double translation_error(const Pose& shown, const Pose& truth) { return (shown.position - truth.position).norm(); }

std::optional<double> pixel_error(const CameraModel& eye, const Pose& shown, const Pose& truth, const Depths& depths,
                                  int columns, int rows) {
  assert(columns > 0 && rows > 0);
  const Pose shown_from_world = inverse(shown);
  double sum = 0.0;
  int points = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * eye.width / columns - 0.5, (row + 0.5) * eye.height / rows - 0.5);
      const Eigen::Vector2d plane = undistorted(eye, pixel);
      const Eigen::Vector3d direction = truth.orientation * Eigen::Vector3d(plane.x(), plane.y(), 1.0);
      const std::optional<double> depth = depths(truth.position, direction);
      if (!depth) continue;
      const Eigen::Vector3d point = truth.position + *depth * direction;
      const std::optional<Eigen::Vector2d> drawn = pixel_of(eye, transformed(shown_from_world, point));
      if (!drawn) continue;
      sum += (*drawn - pixel).norm();
      ++points;
    }
  }
  if (points == 0) return std::nullopt;
  return sum / points;
}

double Errors::mean() const {
  if (errors_.empty()) return 0.0;
  return std::accumulate(errors_.begin(), errors_.end(), 0.0) / static_cast<double>(errors_.size());
}

double Errors::percentile(double percent) const {
  assert(percent > 0.0 && percent <= 100.0);
  if (errors_.empty()) return 0.0;
  // Less a little, so that rounding does not make one more of a whole number.
  const double wanted = std::ceil(percent / 100.0 * static_cast<double>(errors_.size()) - 1e-9);
  const auto index = static_cast<std::ptrdiff_t>(std::max(1.0, wanted)) - 1;
  std::vector<double> sorted = errors_;
  std::nth_element(sorted.begin(), sorted.begin() + index, sorted.end());
  return sorted[static_cast<std::size_t>(index)];
}

}  // namespace ctn::vr::measures
