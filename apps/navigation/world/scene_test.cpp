#include "scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ctn::navigation::world {
namespace {

constexpr double kStraight = std::numbers::pi;

// 6 m x 4 m, its lower left corner at the origin.
WorldFile box_room() {
  WorldFile world;
  world.bounds = {{0, 0}, {6, 4}};
  add_block(world, {{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  world.start = {2, 1, 0};
  world.goal = Point{5, 3};
  return world;
}

// Half a metre wide, from (4, 1) on.
MoverSpec box_that_goes_up() {
  MoverSpec box;
  box.path = {{4, 1}, {4, 3}};
  box.speed = 0.5;
  box.length = box.width = 0.5;
  return box;
}

double ray(const Scene& scene, Pose from, double time = 0.0) {
  std::vector<float> rays(1);
  scene.cast(from, time, kStraight, 30.0, rays);
  return static_cast<double>(rays[0]);
}

TEST(Scene, RaysEndAtTheWallsOfARoom) {
  const Scene scene(box_room(), 1);
  std::vector<float> rays(721);
  const Pose from{2, 1, 0.3};
  scene.cast(from, 0.0, kStraight, 30.0, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double angle = 0.3 + (0.25 * static_cast<double>(i) - 90.0) * kStraight / 180.0;
    const double x = std::cos(angle) > 0.0 ? 4.0 / std::cos(angle) : -2.0 / std::cos(angle);
    const double y = std::sin(angle) > 0.0 ? 3.0 / std::sin(angle) : -1.0 / std::sin(angle);
    ASSERT_NEAR(rays[i], std::min(x, y), 2e-5) << "ray " << i;
  }
}

TEST(Scene, RaysBeyondTheRangeMeetNothing) {
  const Scene scene(box_room(), 1);
  std::vector<float> rays(1);
  scene.cast({2, 1, 0}, 0.0, kStraight, 3.9, rays);
  EXPECT_TRUE(std::isinf(rays[0]));
}

TEST(Scene, RaysMeetMoversWhereTheyAreThen) {
  WorldFile world = box_room();
  world.movers.push_back(box_that_goes_up());
  const Scene scene(world, 1);
  EXPECT_NEAR(ray(scene, {2, 1, 0}, 0.0), 1.75, 1e-5);
  EXPECT_NEAR(ray(scene, {2, 1, 0}, 0.49), 1.75, 1e-5);
  EXPECT_NEAR(ray(scene, {2, 1, 0}, 0.51), 4.0, 1e-5);
  EXPECT_NEAR(ray(scene, {2, 3, 0}, 4.0), 1.75, 1e-5);
}

TEST(Scene, RaysMeetRoundMovers) {
  WorldFile world = box_room();
  MoverSpec disc;
  disc.path = {{4, 1}, {4, 3}};
  disc.speed = 0.5;
  disc.radius = 0.3;
  world.movers.push_back(disc);
  const Scene scene(world, 1);
  EXPECT_NEAR(ray(scene, {2, 1, 0}), 1.7, 1e-5);
  EXPECT_NEAR(ray(scene, {2, 1.18, 0}), 2.0 - 0.24, 1e-5);  // 0.18, 0.24, 0.3
  EXPECT_NEAR(ray(scene, {2, 1.31, 0}), 4.0, 1e-5);
}

// Rays that are cast at movers are chosen by their bearing: none may be missed, all round.
TEST(Scene, AFanMeetsWhatSingleRaysMeet) {
  WorldFile world = box_room();
  for (const Point at : {Point{4, 1}, Point{1, 3}, Point{0.5, 0.5}, Point{2, 3.5}}) {
    MoverSpec box;
    box.path = {at, at + Point{0.1, 0}};
    box.speed = 0.1;
    box.length = 0.5;
    box.width = 0.2;
    box.heading = 0.4;
    world.movers.push_back(box);
  }
  const Scene scene(world, 1);
  for (double heading = -4.0; heading < 4.0; heading += 0.37) {
    for (const double field : {1.0, kStraight, 2.0 * kStraight}) {
      std::vector<float> rays(91);
      scene.cast({2.2, 1.4, heading}, 0.3, field, 30.0, rays);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const double angle = heading + field * (static_cast<double>(i) / 90.0 - 0.5);
        ASSERT_NEAR(rays[i], ray(scene, {2.2, 1.4, angle}, 0.3), 1e-4) << i << " of " << field << " at " << heading;
      }
    }
  }
}

TEST(Scene, KnowsHowFarAwayThingsAre) {
  WorldFile world = box_room();
  MoverSpec box = box_that_goes_up();
  world.movers.push_back(box);
  box.radius = 0.2;
  world.movers.push_back(box);
  const Scene scene(world, 1);
  EXPECT_NEAR(scene.to_walls({2, 1, 0}, 0.6, 2.0), 0.7, 1e-5);
  EXPECT_NEAR(scene.to_walls({2, 1, kStraight / 4.0}, 0.6, 2.0), 1.0 - 0.6 / std::sqrt(2.0), 1e-5);
  EXPECT_NEAR(scene.to_walls({2, 1, 0}, 0.6, 0.5), 0.5, 1e-5);
  EXPECT_NEAR(scene.to_walls({0.2, 1, 0}, 0.6, 0.5), 0.0, 1e-5);
  EXPECT_NEAR(scene.to_mover(0, {2, 1, 0}, 0.6, 0.0), 2.0 - 0.25 - 0.3, 1e-5);
  EXPECT_NEAR(scene.to_mover(1, {2, 1, 0}, 0.6, 0.0), 2.0 - 0.2 - 0.3, 1e-5);
  EXPECT_NEAR(scene.to_mover(0, {4, 1.2, 0}, 0.6, 0.0), 0.0, 1e-5);
}

TEST(Scene, DrawsPhasesFromTheSeed) {
  WorldFile world = box_room();
  MoverSpec box = box_that_goes_up();
  box.phase.reset();
  world.movers.push_back(box);
  EXPECT_EQ(Scene(world, 1).movers()[0].at(0.0), Scene(world, 1).movers()[0].at(0.0));
  EXPECT_NE(Scene(world, 1).movers()[0].at(0.0), Scene(world, 2).movers()[0].at(0.0));
}

}  // namespace
}  // namespace ctn::navigation::world
