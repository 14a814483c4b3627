#include "local_mapper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "scan_filter.h"
#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;
using testing::two_rooms;
using testing::Wall;

TEST(Grid, ClearanceIsTheDistanceToTheNearestObstacle) {
  std::mt19937 random(1);
  const GridFrame frame{-3, 5, 37, 23};
  for (int round = 0; round < 20; ++round) {
    std::vector<std::uint8_t> obstacles(frame.cells());
    for (std::uint8_t& cell : obstacles) cell = random() % 60 == 0 ? 1 : 0;
    const std::vector<float> found = clearance(frame, obstacles, 0.5);
    for (int row = 0; row < frame.height; ++row) {
      for (int column = 0; column < frame.width; ++column) {
        double nearest = 0.5;
        for (int y = 0; y < frame.height; ++y) {
          for (int x = 0; x < frame.width; ++x) {
            if (obstacles[frame.index(x, y)] != 0) nearest = std::min(nearest, kCell * std::hypot(x - column, y - row));
          }
        }
        ASSERT_NEAR(static_cast<double>(found[frame.index(column, row)]), nearest, 1e-6);
      }
    }
  }
}

TEST(Grid, WithoutObstaclesAllIsClear) {
  const GridFrame frame{0, 0, 9, 4};
  for (const float value : clearance(frame, std::vector<std::uint8_t>(frame.cells()), 2.0)) EXPECT_EQ(value, 2.0F);
}

TEST(ScanFilter, RemovesOutliersAndWhatIsNoRange) {
  Scan raw;
  raw.stamp = std::chrono::seconds(7);
  raw.ranges.assign(721, 4.0F);
  raw.ranges[100] = 1.0F;
  raw.ranges[200] = std::numeric_limits<float>::quiet_NaN();
  raw.ranges[300] = -1.0F;
  raw.ranges[400] = std::numeric_limits<float>::infinity();
  const ScanFilter::Result result =
      ScanFilter{}.run(raw, {.stamp = std::chrono::milliseconds(6900), .pose = {1.0, 2.0, 3.0}, .velocity = {}});
  EXPECT_EQ(result.scan->stamp, raw.stamp);
  EXPECT_EQ(result.scan->odometry.pose, (Pose{1.0, 2.0, 3.0}));
  EXPECT_EQ(result.scan->ranges, std::vector<float>(721, 4.0F));
  EXPECT_EQ(result.work.beams, 721U);
}

TEST(ScanFilter, MakesPointsOfHitsThinnedOutWhereTheyAreDense) {
  Scan raw;
  raw.ranges.assign(721, std::numeric_limits<float>::infinity());
  for (std::size_t beam = 0; beam < 200; ++beam) raw.ranges[beam] = 1.0F;  // 4.4 mm apart
  const ScanFilter::Result result = ScanFilter{}.run(raw, {});
  ASSERT_GT(result.scan->points.size(), 20U);
  ASSERT_LT(result.scan->points.size(), 40U);
  for (std::size_t i = 0; i < result.scan->points.size(); ++i) {
    EXPECT_NEAR(std::hypot(result.scan->points[i].x, result.scan->points[i].y), 1.0, 1e-12);
    if (i == 0) continue;
    EXPECT_GE(distance(result.scan->points[i - 1], result.scan->points[i]), ScanFilter::kSpacing);
  }
  EXPECT_LT(result.scan->points.front().y, 0.0);  // to the right
}

LocalMap mapped(LocalMapper& mapper, AnalyticWorld& world) {
  return mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
}

TEST(LocalMapper, KnowsHowFarTheWallsAre) {
  AnalyticWorld world({{{1.0, -5.0}, {1.0, 5.0}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  const LocalMap map = mapped(mapper, world);
  EXPECT_EQ(map.frame.width, 150);
  EXPECT_EQ(map.frame.height, 150);
  for (const double x : {0.2, 0.5, 0.9}) EXPECT_NEAR(map.clearance_at({x, 0.0}), 1.0 - x, 0.05) << x;
  EXPECT_EQ(map.clearance_at({-1.0, 0.0}), LocalMapper::kFarthestClearance);
  EXPECT_EQ(map.clearance_at({50.0, 0.0}), LocalMapper::kFarthestClearance);
}

TEST(LocalMapper, SeesAnObstacleGoThatItStillLooksAt) {
  AnalyticWorld world({{{1.0, -0.3}, {1.0, 0.3}}, {{2.5, -5.0}, {2.5, 5.0}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  for (int i = 0; i < 5; ++i) {
    world.advance(0.05, {});
    mapped(mapper, world);
  }
  ASSERT_LT(mapped(mapper, world).clearance_at({1.0, 0.0}), 0.05);
  world.walls().front() = {{90.0, 0.0}, {90.0, 1.0}};
  int scans = 0;
  while (mapped(mapper, world).clearance_at({1.0, 0.0}) < 0.3 && scans < 20) {
    world.advance(0.05, {});
    ++scans;
  }
  EXPECT_LE(scans, 4);
}

TEST(LocalMapper, RemembersWhatIsBehindForAWhile) {
  AnalyticWorld world({{{1.0, -0.3}, {1.0, 0.3}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  for (int i = 0; i < 3; ++i) {
    world.advance(0.05, {});
    mapped(mapper, world);
  }
  while (world.truth().heading < 3.0) world.advance(0.05, {0.0, 1.5});
  ASSERT_LT(mapped(mapper, world).clearance_at({1.0, 0.0}), 0.05);
  world.advance(LocalMapper::kMemory, {});
  EXPECT_GT(mapped(mapper, world).clearance_at({1.0, 0.0}), 0.9);
}

// What was remembered behind the robot is gone when it backs up to there, and it has not looked that way since.
TEST(LocalMapper, HasNoObstacleWhereTheRobotIs) {
  AnalyticWorld world({{{1.0, -0.1}, {1.0, 0.1}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  for (int i = 0; i < 3; ++i) {
    world.advance(0.05, {});
    mapped(mapper, world);
  }
  while (world.truth().heading < 3.1) world.advance(0.05, {0.0, 1.0});
  world.walls().front() = {{90.0, 0.0}, {90.0, 1.0}};
  while (world.truth().x < 0.6) {
    world.advance(0.05, {-0.5, 0.0});
    mapped(mapper, world);
  }
  EXPECT_LT(mapped(mapper, world).clearance_at({1.0, 0.0}), 0.05);
  while (world.truth().x < 0.85) {
    world.advance(0.05, {-0.5, 0.0});
    mapped(mapper, world);
  }
  EXPECT_EQ(mapped(mapper, world).clearance_at({1.0, 0.0}), LocalMapper::kFarthestClearance);
}

TEST(LocalMapper, MovesWithTheRobot) {
  AnalyticWorld world({{{4.0, -5.0}, {4.0, 5.0}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  EXPECT_EQ(mapped(mapper, world).clearance_at({3.9, 0.0}), LocalMapper::kFarthestClearance);  // beyond its edge
  while (world.truth().x < 2.5) {
    world.advance(0.05, {0.7, 0.0});
    mapped(mapper, world);
  }
  EXPECT_NEAR(mapped(mapper, world).clearance_at({3.5, 0.0}), 0.5, 0.05);
}

TEST(LocalMapper, MoreFreeSpaceIsMoreWork) {
  AnalyticWorld narrow({{{0.6, -5.0}, {0.6, 5.0}}}, {0.0, 0.0, 0.0});
  AnalyticWorld open({}, {0.0, 0.0, 0.0});
  LocalMapper a;
  LocalMapper b;
  const auto cells = [](LocalMapper& mapper, AnalyticWorld& world) {
    return mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).work.cells;
  };
  EXPECT_LT(cells(a, narrow), cells(b, open));
}

}  // namespace
}  // namespace ctn::navigation
