#include "local_planner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;

Command towards(const Point& carrot, double left = 10.0) {
  Command command;
  command.stop = false;
  command.carrot = carrot;
  command.distance_left = left;
  return command;
}

// LM and LP, 25 times a second.
void drive(AnalyticWorld& world, const Command& command, double seconds) {
  LocalMapper mapper;
  LocalPlanner planner;
  for (double until = world.time() + seconds; world.time() < until - 1e-9;) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
    world.advance(0.04, planner.run(map, world.odometry(), command).velocity);
  }
}

TEST(LocalPlanner, DrivesStraightToACarrotAhead) {
  AnalyticWorld world({}, {0.0, 0.0, 0.0});
  drive(world, towards({4.0, 0.0}), 4.0);
  EXPECT_GT(world.truth().x, 2.0);
  EXPECT_NEAR(world.truth().y, 0.0, 0.05);
}

TEST(LocalPlanner, IsNeverFasterThanTheRobotMayBe) {
  LocalMap map;
  LocalPlanner planner;
  const Odometry odometry{{}, {}, {LocalPlanner::kLimits.speed, 0.0}};
  EXPECT_LE(planner.run(map, odometry, towards({4.0, 0.0})).velocity.linear, LocalPlanner::kLimits.speed);
  EXPECT_GE(planner.run(map, odometry, towards({4.0, 0.0})).velocity.linear, 0.9 * LocalPlanner::kLimits.speed);
}

TEST(LocalPlanner, StandsStillWhenToldTo) {
  const LocalPlanner::Result result = LocalPlanner{}.run({}, {}, {});
  EXPECT_EQ(result.velocity, Velocity{});
  EXPECT_EQ(result.work, Work{});
}

TEST(LocalPlanner, TurnsOnTheSpotToLookAroundWhereThereIsRoom) {
  Command command;
  command.look_around = true;
  AnalyticWorld open({{{2.0, -5.0}, {2.0, 5.0}}}, {0.0, 0.0, 0.0});
  drive(open, command, 4.0);
  EXPECT_GT(open.truth().heading, 1.5);
  EXPECT_EQ(open.driven(), 0.0);
  AnalyticWorld tight({{{0.38, -5.0}, {0.38, 5.0}}}, {0.0, 0.0, 0.0});
  drive(tight, command, 4.0);
  EXPECT_EQ(tight.truth().heading, 0.0);
}

TEST(LocalPlanner, TurnsOnTheSpotToACarrotBehind) {
  AnalyticWorld world({}, {0.0, 0.0, 0.0});
  drive(world, towards({-3.0, 0.5}), 1.0);
  EXPECT_LT(std::hypot(world.truth().x, world.truth().y), 0.02);
  EXPECT_GT(world.truth().heading, 0.5);
  drive(world, towards({-3.0, 0.5}), 5.0);
  EXPECT_LT(world.truth().x, -1.5);
}

TEST(LocalPlanner, StopsBeforeAWall) {
  AnalyticWorld world({{{2.0, -20.0}, {2.0, 20.0}}}, {0.0, 0.0, 0.0});
  drive(world, towards({6.0, 0.0}), 12.0);
  EXPECT_FALSE(world.touched());
  EXPECT_GT(world.truth().x, 0.8);
}

TEST(LocalPlanner, GoesRoundAPillarInTheWay) {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, 1.6, -0.1, 1.9, 0.2);
  AnalyticWorld world(walls, {0.0, 0.0, 0.0});
  drive(world, towards({2.9, 0.0}, 4.0), 15.0);
  EXPECT_FALSE(world.touched());
  EXPECT_GT(world.truth().x, 2.5);
}

// An obstacle that the global map lacks stands on the path along a corridor: a corridor 2.5 m wide, and a box in its
// middle that leaves 1 m on one side.
TEST(LocalPlanner, GoesRoundAnObstacleThatTheGlobalMapLacks) {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, -2.0, -1.25, 12.0, 1.25);
  testing::add_box(walls, 4.0, -0.7, 4.6, 0.25);
  AnalyticWorld world(walls, {0.0, 0.0, 0.0});
  Path path;
  path.outcome = Path::Outcome::kFound;
  path.to_goal = true;
  for (int i = 0; i <= 45; ++i) path.points.push_back({i * 0.2, 0.0});  // through the box
  LocalMapper mapper;
  Command command;
  while (world.time() < 40.0 && !command.arrived) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
    command = NavigationCommand{}.run(path, {}, world.odometry()).command;
    world.advance(0.04, LocalPlanner{}.run(map, world.odometry(), command).velocity);
  }
  EXPECT_TRUE(command.arrived) << world.truth().x << " " << world.truth().y;
  EXPECT_FALSE(world.touched());
  EXPECT_LT(world.driven(), 11.0);  // 9 m are the least
}

TEST(LocalPlanner, WaitsWhereNoWayIsLeftAndGoesOnWhenThereIs) {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, -2.0, -1.25, 12.0, 1.25);
  walls.push_back({{3.0, -1.25}, {3.0, 1.25}});
  AnalyticWorld world(walls, {0.0, 0.0, 0.0});
  Command command = towards({4.0, 0.0});
  drive(world, command, 8.0);
  EXPECT_FALSE(world.touched());
  EXPECT_LT(world.truth().x, 3.0);
  const double x = world.truth().x;
  drive(world, command, 8.0);
  EXPECT_FALSE(world.touched());
  EXPECT_NEAR(world.truth().x, x, 0.3);
  world.walls().pop_back();
  drive(world, command, 8.0);
  EXPECT_FALSE(world.touched());
  EXPECT_GT(world.truth().x, 3.5);
}

TEST(LocalPlanner, StopsForWhatStepsInTheWay) {
  AnalyticWorld world({{{9.0, -5.0}, {9.0, 5.0}}}, {0.0, 0.0, 0.0});
  drive(world, towards({8.0, 0.0}), 3.0);
  const double x = world.truth().x;
  world.walls().push_back({{x + 1.2, -20.0}, {x + 1.2, 20.0}});
  drive(world, towards({8.0, 0.0}), 6.0);
  EXPECT_FALSE(world.touched());
  EXPECT_LT(world.truth().x, x + 1.2);
}

TEST(LocalPlanner, NearObstaclesAreMoreWork) {
  AnalyticWorld world({{{0.42, -20.0}, {0.42, 20.0}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
  LocalPlanner planner;
  EXPECT_GT(planner.run(map, world.odometry(), towards({4.0, 0.0})).work.candidates,
            planner.run({}, world.odometry(), towards({4.0, 0.0})).work.candidates);
}

}  // namespace
}  // namespace ctn::navigation
