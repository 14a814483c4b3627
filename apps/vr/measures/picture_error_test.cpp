#include "measures/picture_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ctn::vr::measures {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

CameraModel eye() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 320.0;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

Pose turned_by(double degrees) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitY())), {0.0, 0.0, 0.0}};
}

// A wall two metres in front of the origin, across the camera's z axis.
std::optional<double> wall(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  if (direction.z() <= 0.0) return std::nullopt;
  return (2.0 - origin.z()) / direction.z();
}

TEST(PictureError, OfATurnIsItsAngle) {
  EXPECT_NEAR(rotation_error(turned_by(10.0), turned_by(12.5)), 2.5, 1e-9);
  Pose same = turned_by(10.0);
  same.orientation.coeffs() *= -1.0;
  EXPECT_NEAR(rotation_error(turned_by(10.0), same), 0.0, 1e-6);
}

TEST(PictureError, OfARotationalWarpIsThatOfThePlace) {
  Pose drawn = turned_by(1.0);
  drawn.position = {1.0, 2.0, 3.0};
  Pose warped = turned_by(4.0);
  warped.position = {5.0, 5.0, 5.0};
  const Pose shown = shown_by_rotation(drawn, warped);
  EXPECT_EQ(rotation_error(shown, warped), 0.0);
  EXPECT_EQ(shown.position, drawn.position);
  EXPECT_EQ(translation_error(shown, warped), std::sqrt(16.0 + 9.0 + 4.0));
}

TEST(PictureError, InPixelsIsNoneOfTheTruth) {
  EXPECT_NEAR(*pixel_error(eye(), turned_by(3.0), turned_by(3.0), wall), 0.0, 1e-9);
}

// A step of 1 cm along the wall moves all that is two metres away by 320 x 0.01 / 2 pixels.
TEST(PictureError, InPixelsOfAStepToTheSide) {
  Pose moved;
  moved.position = {0.01, 0.0, 0.0};
  EXPECT_NEAR(*pixel_error(eye(), moved, {}, wall), 1.6, 1e-9);
  EXPECT_NEAR(*pixel_error(eye(), {}, moved, wall), 1.6, 1e-9);
}

// In the middle of the picture a turn by an angle moves things by 320 x tan(angle); one point is the middle.
TEST(PictureError, InPixelsOfATurn) {
  EXPECT_NEAR(*pixel_error(eye(), turned_by(1.0), {}, wall, 1, 1), 320.0 * std::tan(kDegree), 1e-9);
}

TEST(PictureError, InPixelsLeavesOutWhatIsBehind) {
  EXPECT_FALSE(pixel_error(eye(), turned_by(180.0), {}, wall, 1, 1));
  EXPECT_FALSE(pixel_error(eye(), {}, turned_by(180.0), wall, 1, 1));  // the eye sees nothing
}

TEST(Errors, HavePercentilesByRank) {
  Errors errors;
  EXPECT_EQ(errors.percentile(50.0), 0.0);
  EXPECT_EQ(errors.mean(), 0.0);
  for (int i = 100; i >= 1; --i) errors.add(i);
  EXPECT_EQ(errors.count(), 100U);
  EXPECT_EQ(errors.percentile(50.0), 50.0);
  EXPECT_EQ(errors.percentile(95.0), 95.0);
  EXPECT_EQ(errors.percentile(99.9), 100.0);
  EXPECT_EQ(errors.percentile(0.1), 1.0);
  EXPECT_EQ(errors.mean(), 50.5);
}

}  // namespace
}  // namespace ctn::vr::measures
