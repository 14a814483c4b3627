#include "world.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "lens.h"

namespace ctn::face_tracking {
namespace {

World still_world() { return World(Path(0.0, 1), kHalfView); }

TEST(World, CameraStartsOnTheFace) {
  const World world(Path(1.0, 1), kHalfView);
  EXPECT_DOUBLE_EQ(world.sight(0.0).angle, 0.0);
}

TEST(World, CameraTurnsAtMostAtItsLimit) {
  World world = still_world();
  const double before = world.sight(0.0).pan;
  world.turn(1.0, 100.0);
  EXPECT_NEAR(world.sight(1.5).pan - before, 0.5 * kTurnRateMax, 1e-12);
  world.turn(1.5, -100.0);
  EXPECT_NEAR(world.sight(2.0).pan, before, 1e-12);
}

TEST(World, AngleIsFromTheCameraToTheFace) {
  World world = still_world();
  world.turn(0.0, 0.25);
  EXPECT_NEAR(world.sight(1.0).angle, -0.25, 1e-12);
}

TEST(World, MeasuresOverTime) {
  World world = still_world();
  world.turn(0.0, 1.0);
  world.advance(1.0);  // the angle grew evenly from 0 to 1 rad
  EXPECT_NEAR(world.tracking().angle_mean, 0.5, 1e-3);
  EXPECT_NEAR(world.tracking().lost_fraction, 1.0 - kHalfView, 2e-3);
  EXPECT_EQ(world.tracking().samples, 501U);
}

TEST(World, MeasuringStartsWhenToldTo) {
  World world = still_world();
  world.turn(0.0, 1.0);
  world.turn(1.0, 0.0);
  world.begin_measuring(1.0);
  EXPECT_EQ(world.tracking().samples, 0U);
  world.advance(2.0);
  EXPECT_NEAR(world.tracking().angle_mean, 1.0, 1e-9);
  EXPECT_EQ(world.tracking().lost_fraction, 1.0);
}

TEST(World, ALateWorldThreadMeasuresTheSame) {
  World punctual(Path(1.5, 4), kHalfView);
  World late(Path(1.5, 4), kHalfView);
  for (int i = 0; i < 200; ++i) {
    const double time = 0.1 * i;
    const double rate = 2.0 * std::sin(0.7 * i);
    punctual.turn(time, rate);
    punctual.advance(time);
    late.turn(time, rate);
  }
  punctual.advance(20.0);
  late.advance(20.0);
  EXPECT_EQ(punctual.tracking().samples, late.tracking().samples);
  EXPECT_NEAR(punctual.tracking().angle_mean, late.tracking().angle_mean, 1e-9);
}

// For the thread sanitizer, and that no reader ever sees half a command.
TEST(PanLog, ReadersNeverSeeHalfAnEntry) {
  PanLog log({0.0, 0.0, 0.0});
  std::atomic<bool> done = false;
  std::thread writer([&] {
    for (int i = 1; i <= 200000; ++i) log.append({1.0 * i, 2.0 * i, 3.0 * i});
    done = true;
  });
  while (!done) {
    const Pan pan = log.latest();
    ASSERT_EQ(pan.pan, 2.0 * pan.at);
    ASSERT_EQ(pan.rate, 3.0 * pan.at);
  }
  writer.join();
  EXPECT_FALSE(log.entry(5).has_value());
  EXPECT_EQ(log.entry(log.size() - 1)->at, 200000.0);
}

}  // namespace
}  // namespace ctn::face_tracking
