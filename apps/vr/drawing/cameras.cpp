#include "drawing/cameras.h"

#include <fmt/format.h>

#include <cmath>

#include "lens.h"

namespace ctn::vr::drawing {

Status check_size(const CameraModel& camera) {
  if (camera.width >= 1 && camera.height >= 1 && camera.width <= kMaxSide && camera.height <= kMaxSide) return Done{};
  return Error::caller(fmt::format("a picture of {} x {} pixels", camera.width, camera.height),
                       fmt::format("each side must be from 1 to {}", kMaxSide));
}

bool has_distortion(const CameraModel& camera) {
  return camera.k1 != 0.0 || camera.k2 != 0.0 || camera.p1 != 0.0 || camera.p2 != 0.0;
}

CameraModel eye_of(int width, int height) {
  CameraModel eye;
  eye.width = width;
  eye.height = height;
  eye.fx = eye.fy = 0.5 * width;
  eye.cx = 0.5 * width - 0.5;
  eye.cy = 0.5 * height - 0.5;
  return eye;
}

CameraModel with_margin(const CameraModel& eye, double margin) {
  const int x = static_cast<int>(std::lround(eye.width * margin));
  const int y = static_cast<int>(std::lround(eye.height * margin));
  CameraModel camera = eye;
  camera.width += 2 * x;
  camera.height += 2 * y;
  camera.cx += x;
  camera.cy += y;
  return camera;
}

Result<CameraModel> covering(const CameraModel& camera) {
  Eigen::Vector2d low(0.0, 0.0);
  Eigen::Vector2d high(0.0, 0.0);
  const auto look = [&](int x, int y) {
    const Eigen::Vector2d plane = undistorted(camera, {x, y});
    low = low.cwiseMin(plane);
    high = high.cwiseMax(plane);
    const Eigen::Vector2d back = distorted(camera, plane);
    return std::hypot(camera.fx * back.x() + camera.cx - x, camera.fy * back.y() + camera.cy - y) < 0.01;
  };
  bool invertible = true;
  for (int x = 0; x < camera.width; ++x) invertible = look(x, 0) && look(x, camera.height - 1) && invertible;
  for (int y = 0; y < camera.height; ++y) invertible = look(0, y) && look(camera.width - 1, y) && invertible;
  CameraModel drawn;
  drawn.fx = camera.fx;
  drawn.fy = camera.fy;
  constexpr double kBorder = 1.0;  // pixels, for what lies between pixels
  drawn.cx = -low.x() * drawn.fx + kBorder;
  drawn.cy = -low.y() * drawn.fy + kBorder;
  const double width = (high.x() - low.x()) * drawn.fx + 2.0 * kBorder + 1.0;
  const double height = (high.y() - low.y()) * drawn.fy + 2.0 * kBorder + 1.0;
  if (!invertible || !(width <= kMaxSide) || !(height <= kMaxSide)) {
    return Error::caller("the camera's lens bends rays too far to draw its pictures",
                         "give k1, k2, p1, p2 with which each pixel sees another ray, of less than some 160 degrees");
  }
  drawn.width = static_cast<int>(std::ceil(width));
  drawn.height = static_cast<int>(std::ceil(height));
  return drawn;
}

}  // namespace ctn::vr::drawing
