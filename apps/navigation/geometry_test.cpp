#include "geometry.h"

#include <gtest/gtest.h>

#include <numbers>

namespace ctn::navigation {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

TEST(AlongArc, IsStraightWithoutATurn) {
  const Pose end = along_arc({1.0, 2.0, kHalfTurn / 2.0}, 3.0, 0.0);
  EXPECT_NEAR(end.x, 1.0, 1e-12);
  EXPECT_NEAR(end.y, 5.0, 1e-12);
}

TEST(AlongArc, EndsOnItsCircle) {
  const Pose quarter = along_arc({}, 2.0 * kHalfTurn / 2.0, kHalfTurn / 2.0);  // radius 2, centre (0, 2)
  EXPECT_NEAR(quarter.x, 2.0, 1e-12);
  EXPECT_NEAR(quarter.y, 2.0, 1e-12);
  const Pose whole = along_arc({}, 2.0 * kHalfTurn * 2.0, 2.0 * kHalfTurn);
  EXPECT_NEAR(whole.x, 0.0, 1e-12);
  EXPECT_NEAR(whole.y, 0.0, 1e-12);
}

TEST(AlongArc, HasNoJumpWhereTheTurnIsSmall) {
  const Pose below = along_arc({}, 1.0, 1.9999e-4);
  const Pose above = along_arc({}, 1.0, 2.0001e-4);
  EXPECT_NEAR(below.x, above.x, 1e-8);
  EXPECT_NEAR(above.y - below.y, 1e-8, 1e-10);
}

TEST(SegmentDistance, IsToTheNearestPoint) {
  const Segment segment{{0.0, 0.0}, {4.0, 0.0}};
  EXPECT_DOUBLE_EQ(distance(segment, {2.0, 3.0}), 3.0);
  EXPECT_DOUBLE_EQ(distance(segment, {7.0, 4.0}), 5.0);
  EXPECT_DOUBLE_EQ(distance(segment, {-3.0, -4.0}), 5.0);
  EXPECT_DOUBLE_EQ(distance(Segment{{1.0, 1.0}, {1.0, 1.0}}, {1.0, 3.0}), 2.0);
}

TEST(WrappedHeading, StaysInHalfATurn) {
  EXPECT_NEAR(wrapped(1.5 * kHalfTurn), -0.5 * kHalfTurn, 1e-12);
  EXPECT_DOUBLE_EQ(wrapped(kHalfTurn), kHalfTurn);
  EXPECT_DOUBLE_EQ(wrapped(-kHalfTurn), kHalfTurn);
}

}  // namespace
}  // namespace ctn::navigation
