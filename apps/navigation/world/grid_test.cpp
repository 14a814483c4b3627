#include "grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene.h"

namespace ctn::navigation::world {
namespace {

// Two rooms of 4 m x 4 m, with a doorway of `gap` in the middle of the wall between them.
WorldFile two_rooms(double gap) {
  WorldFile world;
  world.bounds = {{0, 0}, {8, 4}};
  add_block(world, {{0, 0}, {8, 0}, {8, 4}, {0, 4}});
  world.walls.push_back({{4, 0}, {4, 2 - gap / 2}});
  world.walls.push_back({{4, 2 + gap / 2}, {4, 4}});
  world.start = {1, 2, 0};
  return world;
}

TEST(Grid, KnowsCellsByTheirPoints) {
  const Grid grid(two_rooms(1.0), 0.1);
  EXPECT_EQ(grid.columns(), 80U);
  EXPECT_EQ(grid.rows(), 40U);
  EXPECT_EQ(grid.cell({0.25, 0.31}), 3U * 80U + 2U);
  EXPECT_NEAR(grid.centre(3 * 80 + 2).x, 0.25, 1e-12);
  EXPECT_FALSE(grid.cell({8.01, 1}).has_value());
  EXPECT_FALSE(grid.cell({-0.01, 1}).has_value());
}

TEST(Grid, MeasuresFromTheCentreOfACell) {
  const Grid grid(two_rooms(1.0), 0.1);
  EXPECT_NEAR(grid.clearance({3.55, 0.95}), 0.45, 1e-6);
  EXPECT_NEAR(grid.clearance({1.95, 2.05}), 1.0, 1e-6);  // no farther than that
  EXPECT_EQ(grid.clearance({-1, 1}), 0.0);
}

TEST(Grid, FindsAWayIfItIsWideEnough) {
  const Grid grid(two_rooms(1.0), 0.1);
  EXPECT_TRUE(grid.path_exists({1, 2}, {7, 2}, 0.4));
  EXPECT_FALSE(grid.path_exists({1, 2}, {7, 2}, 0.5));
  EXPECT_FALSE(grid.path_exists({1, 2}, {7, 3.95}, 0.4));
  EXPECT_FALSE(grid.path_exists({1, 2}, {9, 2}, 0.4));
}

TEST(Explored, SeesWhatTheRaysPass) {
  const WorldFile world = two_rooms(0.0);
  const Scene scene(world, 1);
  Explored explored(world, 0.1);
  EXPECT_EQ(explored.fraction(), 0.0);
  std::vector<float> rays(721);
  // From the middle of the left wall into the room: all of it. The other room cannot be reached and does not count.
  scene.cast({0.11, 2.0, 0.0}, 0.0, std::numbers::pi, 30.0, rays);
  explored.see({0.11, 2.0, 0.0}, std::numbers::pi, 30.0, rays);
  EXPECT_GT(explored.fraction(), 0.99);
  EXPECT_LE(explored.fraction(), 1.0);
}

TEST(Explored, DoesNotSeeThroughWalls) {
  const WorldFile world = two_rooms(1.0);
  const Scene scene(world, 1);
  Explored explored(world, 0.1);
  std::vector<float> rays(721);
  scene.cast(world.start, 0.0, std::numbers::pi, 30.0, rays);
  explored.see(world.start, std::numbers::pi, 30.0, rays);
  // 3 m of the left room less the corners beside the robot; of the right one the trapezium behind the doorway.
  const double right = (1.0 + 1.0 * 7.0 / 3.0) / 2.0 * 4.0;
  EXPECT_NEAR(explored.fraction(), (3.0 * 4.0 + right) / 32.0, 0.03);
  EXPECT_FALSE(explored.seen(*explored.grid().cell({5, 0.5})));
  EXPECT_TRUE(explored.seen(*explored.grid().cell({7, 2})));
  EXPECT_FALSE(explored.seen(*explored.grid().cell({0.5, 2})));
}

}  // namespace
}  // namespace ctn::navigation::world
