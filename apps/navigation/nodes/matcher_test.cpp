#include "matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "grid.h"
#include "pose_graph.h"
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

TEST(PoseGraph, BendsAWayWhoseEndIsKnownToWhereItWas) {
  // Round a square, with an odometer that turns too little; the last pose was seen to be at the first.
  std::vector<Pose> truth{{0.0, 0.0, 0.0}};
  std::vector<Pose> poses{{0.0, 0.0, 0.0}};
  std::vector<Constraint> constraints;
  for (std::size_t i = 0; i < 40; ++i) {
    const double turn = i % 10 == 9 ? std::numbers::pi / 2.0 : 0.0;
    truth.push_back(transformed(truth.back(), Pose{0.5, 0.0, turn}));
    const Pose measured{0.5, 0.0, turn - 0.01};
    poses.push_back(transformed(poses.back(), measured));
    constraints.push_back({i, i + 1, measured, 1.0});
  }
  const double before = distance(position(poses.back()), position(truth.back()));
  ASSERT_GT(before, 0.5);
  constraints.push_back({0, 40, between(truth[0], truth[40]), 100.0});
  relax(poses, constraints);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT(distance(position(poses[i]), position(truth[i])), 0.5 * before) << i;
  }
  EXPECT_LT(distance(position(poses.back()), position(truth.back())), 0.05);
  EXPECT_EQ(poses.front(), truth.front());
}

TEST(PoseGraph, LeavesWhatAgrees) {
  std::vector<Pose> poses{{1.0, 2.0, 0.5}, {2.0, 2.0, 0.1}, {2.0, 3.0, -3.0}};
  const std::vector<Pose> before = poses;
  const std::vector<Constraint> constraints{{0, 1, between(poses[0], poses[1]), 1.0},
                                            {1, 2, between(poses[1], poses[2]), 1.0},
                                            {0, 2, between(poses[0], poses[2]), 5.0}};
  EXPECT_LT(relax(poses, constraints), 1e-20);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(poses[i].x, before[i].x, 1e-9);
    EXPECT_NEAR(poses[i].y, before[i].y, 1e-9);
    EXPECT_NEAR(poses[i].heading, before[i].heading, 1e-9);
  }
}

}  // namespace
}  // namespace ctn::navigation
