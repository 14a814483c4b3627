#include "lens.h"

#include <gtest/gtest.h>

namespace ctn::vr {
namespace {

// The wide lens of the EuRoC data set's left camera.
CameraModel wide() {
  CameraModel camera;
  camera.width = 752;
  camera.height = 480;
  camera.fx = 458.654;
  camera.fy = 457.296;
  camera.cx = 367.215;
  camera.cy = 248.375;
  camera.k1 = -0.28340811;
  camera.k2 = 0.07395907;
  camera.p1 = 0.00019359;
  camera.p2 = 1.76187114e-05;
  return camera;
}

// Computed by hand: x = 0.5, y = -0.25, so r^2 = 0.3125.
TEST(Lens, DistortsAsTheModelSays) {
  CameraModel camera;
  camera.k1 = -0.2;
  camera.k2 = 0.1;
  camera.p1 = 0.01;
  camera.p2 = -0.02;
  const auto pixel = pixel_of(camera, {1.0, -0.5, 2.0});
  ASSERT_TRUE(pixel);
  constexpr double kRadial = 1.0 - 0.2 * 0.3125 + 0.1 * 0.3125 * 0.3125;
  EXPECT_NEAR(pixel->x(), 400.0 * (0.5 * kRadial + 2.0 * 0.01 * -0.125 - 0.02 * (0.3125 + 0.5)) + 319.5, 1e-9);
  EXPECT_NEAR(pixel->y(), 400.0 * (-0.25 * kRadial + 0.01 * (0.3125 + 0.125) + 2.0 * -0.02 * -0.125) + 239.5, 1e-9);
}

TEST(Lens, FindsTheRayOfEachPixel) {
  const CameraModel camera = wide();
  for (int y = 0; y < camera.height; y += 7) {
    for (int x = 0; x < camera.width; x += 7) {
      const Eigen::Vector2d plane = undistorted(camera, {x, y});
      const auto pixel = pixel_of(camera, {3.0 * plane.x(), 3.0 * plane.y(), 3.0});
      ASSERT_TRUE(pixel);
      ASSERT_NEAR(pixel->x(), x, 1e-6);
      ASSERT_NEAR(pixel->y(), y, 1e-6);
    }
  }
}

TEST(Lens, SeesNothingBehindIt) {
  EXPECT_FALSE(pixel_of(wide(), {0.1, 0.1, -1.0}));
  EXPECT_FALSE(pixel_of(wide(), {0.1, 0.1, 0.0}));
  EXPECT_TRUE(inside(wide(), {751.4, 479.4}));
  EXPECT_FALSE(inside(wide(), {751.5, 10.0}));
  EXPECT_FALSE(inside(wide(), {10.0, -0.6}));
}

TEST(Poses, AreComposedAndInverted) {
  const Pose frame{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized())),
                   {1.0, -2.0, 0.5}};
  const Pose other{Eigen::Quaterniond(Eigen::AngleAxisd(-1.1, Eigen::Vector3d(0.0, 1.0, 1.0).normalized())),
                   {0.3, 0.2, 0.1}};
  const Eigen::Vector3d point(0.4, -0.6, 2.0);
  EXPECT_LT((transformed(transformed(frame, other), point) - transformed(frame, transformed(other, point))).norm(),
            1e-12);
  EXPECT_LT((transformed(inverse(frame), transformed(frame, point)) - point).norm(), 1e-12);
}

}  // namespace
}  // namespace ctn::vr
