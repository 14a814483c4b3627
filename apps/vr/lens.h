// Where a camera sees a point, and along which ray a pixel looks: the arithmetic of CameraModel (sensors.h).
//
// Units: pixels, metres. Thread safety: functions of their arguments.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "sensors.h"

namespace ctn::vr {

// (x, y) of a point in the camera's frame over its z, as the lens distorts it.
inline Eigen::Vector2d distorted(const CameraModel& camera, const Eigen::Vector2d& plane) {
  const double x = plane.x();
  const double y = plane.y();
  const double square = x * x + y * y;
  const double radial = 1.0 + square * (camera.k1 + square * camera.k2);
  return {x * radial + 2.0 * camera.p1 * x * y + camera.p2 * (square + 2.0 * x * x),
          y * radial + camera.p1 * (square + 2.0 * y * y) + 2.0 * camera.p2 * x * y};
}

// The pixel of a point that is given in the camera's frame; none where it is not in front of the camera. It may lie
// outside of the picture.
inline std::optional<Eigen::Vector2d> pixel_of(const CameraModel& camera, const Eigen::Vector3d& point) {
  constexpr double kNearest = 1e-6;
  if (point.z() < kNearest) return std::nullopt;
  const Eigen::Vector2d seen = distorted(camera, {point.x() / point.z(), point.y() / point.z()});
  return Eigen::Vector2d(camera.fx * seen.x() + camera.cx, camera.fy * seen.y() + camera.cy);
}

// (x, y) of the ray (x, y, 1) along which a pixel looks: what distorted() takes to the pixel, found by iteration.
inline Eigen::Vector2d undistorted(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d wanted((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  Eigen::Vector2d plane = wanted;
  constexpr int kMaxRounds = 50;
  for (int i = 0; i < kMaxRounds; ++i) {
    const Eigen::Vector2d off = wanted - distorted(camera, plane);
    plane += off;
    if (off.squaredNorm() < 1e-24) break;
  }
  return plane;
}

// Whether a pixel is in the picture.
inline bool inside(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width - 0.5 && pixel.y() < camera.height - 0.5;
}

}  // namespace ctn::vr
