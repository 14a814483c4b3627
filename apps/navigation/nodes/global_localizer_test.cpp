#include "global_localizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "global_mapper.h"
#include "navigation_command.h"
#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;
using testing::Errors;
using testing::two_rooms;

constexpr Errors kDrifting{.range = 0.01, .way = 0.03, .turn = 0.04, .turn_noise = 0.01};

SharedScan scan_of(AnalyticWorld& world) { return ScanFilter{}.run(world.scan(), world.odometry()).scan; }

double error_of(const Localization& localization, AnalyticWorld& world) {
  return distance(position(localization.pose_at(world.odometry())), position(world.truth()));
}

// Drives through points, a scan every 0.2 s. Steers by the truth: what is under test must not decide where it goes.
class Tour {
 public:
  explicit Tour(AnalyticWorld& world) : world_(world) {}

  void visit(const Point& target) {
    for (int i = 0; i < 1000 && distance(position(world_.truth()), target) > 0.15; ++i) {
      const Pose& pose = world_.truth();
      const double bearing = wrapped(std::atan2(target.y - pose.y, target.x - pose.x) - pose.heading);
      world_.advance(0.2, {std::abs(bearing) < 0.3 ? 0.5 : 0.0, std::clamp(2.0 * bearing, -1.0, 1.0)});
      last = localizer.run({scan_of(world_)});
      worst = std::max(worst, error_of(last.localization, world_));
    }
  }

  GlobalLocalizer localizer;
  GlobalLocalizer::Result last;
  double worst = 0.0;

 private:
  AnalyticWorld& world_;
};

TEST(GlobalLocalizer, SkipsScansThatTellNothingNew) {
  AnalyticWorld world(two_rooms(), {2.0, 2.0, 0.0});
  GlobalLocalizer localizer;
  const GlobalLocalizer::Result first = localizer.run({scan_of(world)});
  EXPECT_EQ(first.mode, GlobalLocalizer::Mode::kMatch);
  EXPECT_TRUE(first.news);
  world.advance(0.5, {0.3, 0.0});
  const GlobalLocalizer::Result second = localizer.run({scan_of(world), scan_of(world)});
  EXPECT_EQ(second.mode, GlobalLocalizer::Mode::kSkip);
  EXPECT_FALSE(second.news);
  EXPECT_EQ(second.localization.keyframes, first.localization.keyframes);  // the same list, not a copy
  EXPECT_EQ(second.localization.stamp, world.now());
  EXPECT_EQ(second.work.expanded, 2U);  // looked at both, and for the pose at the newer one alone
  EXPECT_EQ(second.work.cells, 0U);
  EXPECT_EQ(localizer.run({scan_of(world)}).work.candidates, second.work.candidates);
  EXPECT_EQ(localizer.run({}).work, Work{});
}

TEST(GlobalLocalizer, TakesInAllThatIsBuffered) {
  AnalyticWorld world(two_rooms(), {1.0, 2.0, 0.0});
  std::vector<SharedScan> scans;
  for (int i = 0; i < 4; ++i) {
    scans.push_back(scan_of(world));
    world.advance(1.4, {0.5, 0.0});
  }
  GlobalLocalizer one;
  const GlobalLocalizer::Result together = one.run(scans);
  GlobalLocalizer other;
  GlobalLocalizer::Result last;
  for (const SharedScan& scan : scans) last = other.run({scan});
  ASSERT_EQ(together.localization.keyframes->size(), 4U);
  EXPECT_EQ(together.localization.correction, last.localization.correction);
}

TEST(GlobalLocalizer, MatchingCostsFarMoreThanSkipping) {
  AnalyticWorld world(two_rooms(), {1.0, 2.0, 0.0});
  GlobalLocalizer localizer;
  localizer.run({scan_of(world)});
  const Work skip = localizer.run({scan_of(world)}).work;
  world.advance(2.0, {0.5, 0.0});
  const Work match = localizer.run({scan_of(world)}).work;
  EXPECT_GT(match.candidates, 2 * skip.candidates);
  EXPECT_GT(match.cells, 300'000U);
  EXPECT_EQ(skip.cells, 0U);
}

TEST(GlobalLocalizer, CorrectsOdometryThatDrifts) {
  AnalyticWorld world(two_rooms(), {2.0, 3.0, 0.0}, kDrifting);
  Tour tour(world);
  for (int round = 0; round < 2; ++round) {
    for (const Point& target : {Point{4.0, 3.0}, Point{6.0, 3.0}, Point{6.4, 4.8}, Point{8.8, 4.5}, Point{8.8, 1.5},
                                Point{6.3, 1.3}, Point{6.0, 3.0}, Point{4.0, 3.0}, Point{1.5, 4.5}, Point{1.5, 1.5}}) {
      tour.visit(target);
    }
  }
  ASSERT_FALSE(world.touched());
  ASSERT_GT(world.driven(), 30.0);
  EXPECT_GT(distance(position(world.odometry().pose), position(world.truth())), 0.5);
  EXPECT_LT(tour.worst, 0.25);
  EXPECT_LT(error_of(tour.last.localization, world), 0.2);
}

TEST(GlobalLocalizer, ClosesALoopWhenItComesBack) {
  AnalyticWorld world(testing::office(), {2.0, 13.0, 0.0}, kDrifting);
  Tour tour(world);
  for (const Point& target : {Point{7.0, 9.2}, Point{23.0, 9.2}, Point{23.0, 16.8}, Point{8.5, 16.8}}) {
    tour.visit(target);
  }
  ASSERT_EQ(tour.last.localization.loops, 0U);
  tour.visit({8.5, 9.2});
  tour.visit({14.0, 9.2});
  tour.visit({20.0, 9.2});
  EXPECT_GT(tour.last.localization.loops, 0U);
  EXPECT_LT(error_of(tour.last.localization, world), 0.5);
}

// Closing a loop moves keyframes. What was planned on the map from before lies where it did beside its newest keyframe.
TEST(GlobalLocalizer, FindsTheRobotOnAMapFromBeforeALoopWasClosed) {
  const Pose old_keyframe{4.0, 2.0, 0.3};
  const Pose robot_there{4.6, 2.3, 0.5};
  Localization localization;
  EXPECT_EQ(localization.correction_on({}), localization.correction);

  const Anchor anchor{2, old_keyframe};
  const Pose moved{0.3, -0.2, 0.02};  // the whole map around
  Odometry odometry;
  odometry.pose = {1.0, 0.0, 0.1};
  localization.keyframes = std::make_shared<const std::vector<Keyframe>>(
      std::vector<Keyframe>{{{}, nullptr}, {transformed(moved, old_keyframe), nullptr}, {{9.0, 9.0, 1.0}, nullptr}});
  localization.correction = transformed(transformed(moved, robot_there), inverse(odometry.pose));
  const Pose found = localization.pose_on(anchor, odometry);
  EXPECT_NEAR(found.x, robot_there.x, 1e-9);
  EXPECT_NEAR(found.y, robot_there.y, 1e-9);
  EXPECT_NEAR(found.heading, robot_there.heading, 1e-9);
  EXPECT_EQ(localization.pose_on({}, odometry), localization.pose_at(odometry));

  Path path;
  path.outcome = Path::Outcome::kFound;
  path.anchor = anchor;
  for (int i = 0; i < 20; ++i) path.points.push_back(transformed(robot_there, Point{0.2 * i, 0.0}));
  const Command command = NavigationCommand{}.run(path, localization, odometry).command;
  const Point ahead = transformed(inverse(odometry.pose), command.carrot);
  EXPECT_NEAR(ahead.x, NavigationCommand::kLookahead, 1e-9);
  EXPECT_NEAR(ahead.y, 0.0, 1e-9);
}

TEST(GlobalMapper, MapsWhatTheKeyframesSaw) {
  AnalyticWorld world(two_rooms(), {2.0, 2.0, 0.0});
  Tour tour(world);
  for (const Point& target : {Point{3.5, 3.0}, Point{6.2, 3.0}, Point{6.2, 4.8}, Point{3.5, 3.2}, Point{1.5, 3.0}}) {
    tour.visit(target);
  }
  GlobalMapper mapper;
  const SharedMap map = mapper.run(tour.last.localization).map;
  EXPECT_EQ(map->anchor.keyframes, tour.last.localization.keyframes->size());
  EXPECT_EQ(map->anchor.newest, tour.last.localization.keyframes->back().pose);
  EXPECT_EQ(map->at({2.0, 2.0}), Cell::kFree);
  EXPECT_EQ(map->at({5.0, 3.0}), Cell::kFree);       // the doorway
  EXPECT_EQ(map->at({-1.0, 3.0}), Cell::kUnknown);   // outside
  EXPECT_EQ(map->at({7.65, 2.85}), Cell::kUnknown);  // inside the pillar
  int obstacles = 0;
  int near_wall = 0;
  for (int row = 0; row < map->frame.height; ++row) {
    for (int column = 0; column < map->frame.width; ++column) {
      if (map->cells[map->frame.index(column, row)] != Cell::kObstacle) continue;
      const Point at = map->frame.centre(column, row);
      const double to_outer = std::min({std::abs(at.x), std::abs(at.x - 10.0), std::abs(at.y), std::abs(at.y - 6.0)});
      const bool at_pillar = std::abs(at.x - 7.65) < 0.35 && std::abs(at.y - 2.85) < 0.35;
      ++obstacles;
      if (to_outer < 0.1 || std::abs(at.x - 5.0) < 0.1 || at_pillar) ++near_wall;
    }
  }
  EXPECT_GT(obstacles, 400);
  EXPECT_GT(near_wall, obstacles * 97 / 100);
}

// A box goes along the doorway while the robot drives towards it.
TEST(GlobalMapper, WhatMovesClosesNoDoorway) {
  AnalyticWorld world(two_rooms(), {1.0, 3.0, 0.0});
  GlobalLocalizer localizer;
  GlobalMapper mapper;
  const std::vector<testing::Wall> walls = world.walls();
  SharedMap map;
  for (int step = 0; step < 5; ++step) {
    world.walls() = walls;
    const double y = 2.35 + 0.25 * step;
    testing::add_box(world.walls(), 4.8, y, 5.1, y + 0.25);
    const SharedScan scan = ScanFilter{}.run(world.scan(), world.odometry()).scan;
    map = mapper.run(localizer.run({scan}).localization).map;
    world.advance(1.5, {0.5, 0.0});
  }
  EXPECT_EQ(map->anchor.keyframes, 5U);
  for (double y = 2.5; y < 3.5; y += 0.04) EXPECT_EQ(map->at({4.8, y}), Cell::kFree) << y;
  EXPECT_EQ(map->at({5.0, 1.5}), Cell::kObstacle);
}

TEST(GlobalMapper, CostsMoreTheMoreWasSeenAndNothingWithoutNews) {
  AnalyticWorld world(two_rooms(), {2.0, 3.0, 0.0});
  Tour tour(world);
  GlobalMapper mapper;
  EXPECT_TRUE(mapper.run(tour.localizer.run({}).localization).map->cells.empty());
  std::uint64_t before = 0;
  for (const Point& target : {Point{3.5, 3.0}, Point{6.2, 3.0}, Point{6.2, 4.8}}) {
    tour.visit(target);
    const GlobalMapper::Result result = mapper.run(tour.last.localization);
    EXPECT_GT(result.work.cells, before);
    before = result.work.cells;
    const GlobalMapper::Result again = mapper.run(tour.last.localization);
    EXPECT_EQ(again.map, result.map);
    EXPECT_EQ(again.work, Work{});
  }
}

}  // namespace
}  // namespace ctn::navigation
