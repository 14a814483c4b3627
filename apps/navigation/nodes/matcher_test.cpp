#include "matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "grid.h"
#include "scan_filter.h"
#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;
using testing::two_rooms;

std::vector<Point> points_seen_from(const Pose& pose) {
  AnalyticWorld world(two_rooms(), pose);
  return ScanFilter{}.run(world.scan(), world.odometry()).scan->points;
}

TEST(Geometry, AFrameSeenFromItselfIsTheOrigin) {
  const Pose frame{3.0, -2.0, 2.5};
  const Pose seen = between(frame, frame);
  EXPECT_NEAR(seen.x, 0.0, 1e-12);
  EXPECT_NEAR(seen.y, 0.0, 1e-12);
  EXPECT_NEAR(seen.heading, 0.0, 1e-12);
  const Pose there = transformed(frame, between(frame, {-1.0, 4.0, -3.0}));
  EXPECT_NEAR(there.x, -1.0, 1e-12);
  EXPECT_NEAR(there.y, 4.0, 1e-12);
  EXPECT_NEAR(there.heading, -3.0, 1e-12);
}

TEST(Matcher, FindsThePoseThatTheScanWasTakenFrom) {
  const Pose before{2.0, 2.0, 0.3};
  for (const Pose& truth : {Pose{2.3, 2.1, 0.45}, Pose{1.9, 2.2, 0.2}, Pose{2.0, 2.0, 0.3}}) {
    Matcher matcher;
    matcher.start({truth.x + 0.15, truth.y - 0.11, truth.heading + 0.1});  // what odometry says
    matcher.add(before, points_seen_from(before));
    const Matcher::Match match = matcher.match(points_seen_from(truth), {});
    EXPECT_NEAR(match.pose.x, truth.x, kCell);
    EXPECT_NEAR(match.pose.y, truth.y, kCell);
    EXPECT_NEAR(match.pose.heading, truth.heading, 0.01);
    EXPECT_GT(match.score, 0.5);
  }
}

TEST(Matcher, RefinesAPoseToLessThanACell) {
  const Pose before{2.0, 2.0, 0.3};
  const Pose truth{2.1, 2.05, 0.33};
  Matcher matcher;
  matcher.start(before);
  matcher.add(before, points_seen_from(before));
  const Matcher::Match match =
      matcher.refine(points_seen_from(truth), {truth.x + 0.02, truth.y - 0.03, truth.heading + 0.01}, {0.04, 0.02});
  EXPECT_NEAR(match.pose.x, truth.x, 0.75 * kCell);
  EXPECT_NEAR(match.pose.y, truth.y, 0.75 * kCell);
  EXPECT_NEAR(match.pose.heading, truth.heading, 0.0065);
}

TEST(Matcher, ScoresNothingWhereNothingWasSeen) {
  Matcher matcher;
  const Pose here{2.0, 2.0, 0.0};
  matcher.start(here);
  const Matcher::Match match = matcher.match(points_seen_from(here), {});
  EXPECT_EQ(match.score, 0.0);
  EXPECT_EQ(matcher.match({}, {}).pose, here);
}

TEST(Matcher, CountsTheSameWorkForTheSameWindow) {
  const std::vector<Point> points = points_seen_from({2.0, 2.0, 0.0});
  Matcher matcher;
  const auto work_of = [&](const Matcher::Window& window) {
    matcher.start({2.0, 2.0, 0.0});
    matcher.match(points, window);
    return matcher.take_work();
  };
  const Work small = work_of({});
  EXPECT_GT(work_of({0.8, 0.3}).candidates, 2 * small.candidates);
  EXPECT_EQ(work_of({}), small);
}

// A scan in a corridor along the x axis, 2.5 m wide, in which nothing but its walls can be seen.
std::vector<Point> points_in_corridor(const Pose& pose, std::uint64_t seed) {
  AnalyticWorld world({}, pose, {.range = 0.01}, seed);
  testing::add_box(world.walls(), -40.0, 0.0, 40.0, 2.5);
  return ScanFilter{}.run(world.scan(), world.odometry()).scan->points;
}

// What a robot has seen on the last metres before x = 0, in a map whose axes are turned by `turn`.
void see_corridor(Matcher& matcher, double turn) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Pose pose{-0.45 * static_cast<double>(i + 1), 1.25, 0.0};
    matcher.add(transformed(Pose{0.0, 0.0, turn}, pose), points_in_corridor(pose, i + 1));
  }
}

TEST(Matcher, KnowsThatACorridorSaysNothingAlongItsAxis) {
  for (const double turn : {0.0, 0.7}) {  // also where the axis is not one of the grid's
    const Pose in_corridor{0.0, 1.25, 0.05};
    Matcher matcher;
    matcher.start(transformed(Pose{0.0, 0.0, turn}, in_corridor));
    see_corridor(matcher, turn);
    const Matcher::Match match = matcher.match(points_in_corridor(in_corridor, 99), {});
    const PoseMatrix covariance = turned(match.covariance, -turn);  // along the corridor's axes
    const PoseMatrix information = inverse(covariance);
    EXPECT_GT(std::sqrt(covariance.xx), 0.1);  // the window is 0.32 to each side
    EXPECT_LT(std::sqrt(covariance.yy), 0.03);
    EXPECT_LT(std::sqrt(covariance.hh), 0.01);
    EXPECT_LT(information.xx, 0.02 * information.yy);
  }
  // In a room both directions are as sure.
  const Pose here{2.0, 2.0, 0.3};
  Matcher matcher;
  matcher.start(here);
  matcher.add(here, points_seen_from(here));
  const PoseMatrix covariance = matcher.match(points_seen_from(here), {}).covariance;
  EXPECT_LT(std::sqrt(covariance.xx), 0.02);
  EXPECT_LT(std::sqrt(covariance.yy), 0.02);
}

TEST(Matcher, LeavesTheWayAlongACorridorToWhatWasKnown) {
  const Pose truth{0.0, 1.3, 0.03};
  const Pose expected{0.1, 1.26, 0.01};
  Matcher matcher;
  matcher.start(expected);
  see_corridor(matcher, 0.0);
  const PoseMatrix known = inverse(covariance_of(0.013, 0.05, 0.02));
  const Matcher::Match match = matcher.match(points_in_corridor(truth, 99), {}, known);
  EXPECT_NEAR(match.pose.x, expected.x, 0.015);
  EXPECT_NEAR(match.pose.y, truth.y, 0.015);
  EXPECT_NEAR(match.pose.heading, truth.heading, 0.004);
}

TEST(PoseMatrix, TurnsAndInverts) {
  const PoseMatrix matrix = turned(covariance_of(0.1, 0.4, 0.02), 0.5) + PoseMatrix{0.0, 0.0, 1e-4, 0.0, -2e-4, 0.0};
  const PoseMatrix back = inverse(inverse(matrix));
  EXPECT_NEAR(back.xx, matrix.xx, 1e-12);
  EXPECT_NEAR(back.xy, matrix.xy, 1e-12);
  EXPECT_NEAR(back.xh, matrix.xh, 1e-12);
  EXPECT_NEAR(back.yy, matrix.yy, 1e-12);
  EXPECT_NEAR(back.yh, matrix.yh, 1e-12);
  EXPECT_NEAR(back.hh, matrix.hh, 1e-12);
  // Ten centimetres ahead of a robot that looks along y are ten centimetres along y.
  const PoseMatrix ahead = turned(covariance_of(0.1, 0.0, 0.0), std::numbers::pi / 2.0);
  EXPECT_NEAR(ahead.xx, 0.0, 1e-12);
  EXPECT_NEAR(ahead.yy, 0.01, 1e-12);
  EXPECT_DOUBLE_EQ(squared(inverse(covariance_of(0.1, 0.2, 0.5)), {0.1, 0.2, 0.5}), 3.0);
}

}  // namespace
}  // namespace ctn::navigation
