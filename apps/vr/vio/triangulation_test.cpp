#include "vio/triangulation.h"

#include <gtest/gtest.h>

#include <random>

#include "vio/rotation.h"

namespace ctn::vr {
namespace {

constexpr double kNoise = 1.0 / 400.0;

// Of cameras that move by `step` to the right and turn a little each.
std::vector<View> views_of(const Eigen::Vector3d& point, double step, std::size_t count, double noise) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<View> views;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<double>(i);
    const Pose pose{rotation({0.01 * at, -0.02 * at, 0.005 * at}), {step * at, 0.01 * step * at, 0.0}};
    const Eigen::Vector3d seen = transformed(inverse(pose), point);
    views.push_back({pose, seen.hnormalized() + noise * Eigen::Vector2d(normal(random), normal(random))});
  }
  return views;
}

TEST(Triangulation, FindsThePoint) {
  for (const double distance : {0.3, 1.0, 4.0, 20.0}) {
    const Eigen::Vector3d point = distance * Eigen::Vector3d(0.2, -0.1, 1.0);
    const Triangulation found = triangulate(views_of(point, 0.05, 10, 0.0), kNoise);
    ASSERT_TRUE(found.point) << distance;
    EXPECT_LT((*found.point - point).norm(), 1e-3 * distance);
    EXPECT_GE(found.work.observations, 20U);
  }
}

TEST(Triangulation, OfNoisyViewsIsAsNearAsTheyTell) {
  const Eigen::Vector3d point(0.3, 0.2, 3.0);
  const Triangulation found = triangulate(views_of(point, 0.05, 12, kNoise), kNoise);
  ASSERT_TRUE(found.point);
  // Parallax of 0.55 m / 3 m, noise of 1 / 400 in 12 views.
  EXPECT_LT((*found.point - point).norm(), 0.1);
}

TEST(Triangulation, WithoutParallaxThePointIsFarInTheRightDirection) {
  const Eigen::Vector3d point(0.3, 0.2, 3.0);
  const Triangulation found = triangulate(views_of(point, 0.0, 8, 0.3 * kNoise), kNoise);
  ASSERT_TRUE(found.point);
  EXPECT_LT((found.point->hnormalized() - point.hnormalized()).norm(), kNoise);
}

TEST(Triangulation, NothingWhereNoPointFits) {
  std::vector<View> views = views_of({0.3, 0.2, 3.0}, 0.05, 6, 0.0);
  views[2].point.y() += 0.2;
  views[4].point.y() -= 0.2;
  EXPECT_FALSE(triangulate(views, kNoise).point);
  EXPECT_FALSE(triangulate({views.front()}, kNoise).point);
  EXPECT_FALSE(triangulate({}, kNoise).point);
}

}  // namespace
}  // namespace ctn::vr
