#include "tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "lens.h"
#include "world.h"

namespace ctn::face_tracking {
namespace {

constexpr std::size_t kFew = 3000;  // as good as the default here, and quick

struct Loop {
  double period;  // seconds between pictures
  double delay;   // from a picture to the command made of it
  double seconds = 20.0;
};

// The loop in virtual time with a perfect detector: pictures every `period`, commands `delay` later.
Tracking run(const Loop& loop, double speed, std::uint64_t seed) {
  struct Pending {
    double due;
    Observation observation;
  };
  World world(Path(speed, seed), kHalfView);
  Tracker tracker(1, kFew);
  std::deque<Pending> pending;
  bool measuring = false;
  for (double time = 0.0; time < loop.seconds; time += loop.period) {
    while (!pending.empty() && pending.front().due <= time) {
      const Pending next = pending.front();
      pending.pop_front();
      tracker.observe(next.observation);
      world.turn(next.due, tracker.pan_rate(next.due, world.sight(next.due).pan));
    }
    if (!measuring && time > 2.0) world.begin_measuring(time);
    measuring = measuring || time > 2.0;
    const Sight sight = world.sight(time);
    Observation observation{time, sight.pan, std::nullopt};
    if (std::abs(sight.angle) < 0.85 * kHalfView) observation.face = sight.angle;
    pending.push_back({time + loop.delay, observation});
  }
  world.advance(loop.seconds);
  return world.tracking();
}

Tracking mean_run(const Loop& loop, double speed) {
  Tracking mean;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Tracking tracking = run(loop, speed, seed);
    mean.angle_mean += tracking.angle_mean / 5.0;
    mean.lost_fraction += tracking.lost_fraction / 5.0;
  }
  return mean;
}

TEST(Tracker, KeepsASlowFaceInView) {
  const Tracking tracking = mean_run({0.09, 0.09}, 0.5);
  EXPECT_EQ(tracking.lost_fraction, 0.0);
  EXPECT_LT(tracking.angle_mean, 0.05);
}

// The angle is what the scheduler is judged by: it has to tell a late reaction from a prompt one.
TEST(Tracker, TheAngleGrowsWithTheResponseTime) {
  for (const double speed : {1.0, 1.5}) {
    double before = 0.0;
    for (const Loop loop : {Loop{0.06, 0.085}, Loop{0.09, 0.09}, Loop{0.12, 0.15}, Loop{0.2, 0.2}}) {
      const double angle = mean_run(loop, speed).angle_mean;
      EXPECT_GT(angle, 1.05 * before) << "period " << loop.period << " delay " << loop.delay;
      before = angle;
    }
  }
}

TEST(Tracker, TheAngleGrowsWithTheSpeed) {
  double before = 0.0;
  for (const double speed : {0.5, 1.0, 1.5, 2.0}) {
    const double angle = mean_run({0.09, 0.09}, speed).angle_mean;
    EXPECT_GT(angle, before);
    before = angle;
  }
}

TEST(Tracker, FindsALostFaceAgain) {
  Tracker tracker(1, kFew);
  tracker.observe({0.0, 0.0, 0.1});
  double time = 0.0;
  double pan = 0.0;
  const double face = 2.5;  // jumped out of the picture, stands still
  bool searched = false;
  for (; time < 10.0 && std::abs(wrapped(face - pan)) > 0.05; time += 0.1) {
    const double angle = wrapped(face - pan);
    Observation observation{time, pan, std::nullopt};
    if (std::abs(angle) < 0.8 * kHalfView) observation.face = angle;
    tracker.observe(observation);
    pan += 0.1 * tracker.pan_rate(time, pan);
    searched = searched || tracker.searching();
  }
  EXPECT_TRUE(searched);
  EXPECT_LT(time, 6.0);
}

TEST(Tracker, AWrongDetectionDoesNotThrowIt) {
  Tracker tracker(1, kFew);
  for (int i = 0; i < 20; ++i) tracker.observe({0.1 * i, 0.0, 0.0});
  tracker.observe({2.0, 0.0, 0.4});
  EXPECT_LT(std::abs(tracker.pan_rate(2.0, 0.0)), 0.8);
}

TEST(Tracker, AsksForNoMoreThanTheMotorCan) {
  Tracker tracker(1, kFew);
  tracker.observe({0.0, 0.0, 0.5});
  EXPECT_LE(std::abs(tracker.pan_rate(0.0, -2.0)), kTurnRateMax);
}

}  // namespace
}  // namespace ctn::face_tracking
