#include "run/shortest_way.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace ctn::navigation::run {
namespace {

// 10 m x 6 m, from (1, 1) to (9, 1).
world::WorldFile room() {
  world::WorldFile world;
  world.bounds = {{0, 0}, {10, 6}};
  world::add_block(world, {{0, 0}, {10, 0}, {10, 6}, {0, 6}});
  world.start = {1, 1, 0};
  world.goal = Point{9, 1};
  return world;
}

TEST(ShortestWay, IsStraightWhereNothingIsInBetween) {
  world::WorldFile world = room();
  EXPECT_NEAR(shortest_way(world).value_or(0.0), 8.0, 1e-9);
  world.goal = Point{8.5, 4.7};
  EXPECT_NEAR(shortest_way(world).value_or(0.0), std::hypot(7.5, 3.7), 1e-9);
}

TEST(ShortestWay, GoesAroundACorner) {
  world::WorldFile world = room();
  world.walls.push_back({{5, 0}, {5, 4}});
  // Two tangents to the disc around the wall's end on which the robot's centre must not be, and the arc between.
  const double radius = 0.28;
  const double away = std::hypot(4.0, 3.0);
  const double tangent = std::sqrt(away * away - radius * radius);
  const double arc = 2.0 * (std::acos(-1.0) - std::atan2(4.0, 3.0) - std::acos(radius / away)) * radius;
  EXPECT_NEAR(shortest_way(world).value_or(0.0), 2.0 * tangent + arc, 0.25);
  EXPECT_GE(shortest_way(world).value_or(0.0), 2.0 * tangent + arc - 0.1);
}

TEST(ShortestWay, NeedsRoomAndAGoal) {
  world::WorldFile world = room();
  world.walls.push_back({{5, 0}, {5, 2.8}});
  world.walls.push_back({{5, 3.2}, {5, 6}});  // a gap of 0.4 m
  EXPECT_EQ(shortest_way(world), std::nullopt);
  world = room();
  world.goal.reset();
  EXPECT_EQ(shortest_way(world), std::nullopt);
}

}  // namespace
}  // namespace ctn::navigation::run
