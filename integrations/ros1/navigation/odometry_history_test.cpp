#include "ros1/navigation/odometry_history.h"

#include <gtest/gtest.h>

namespace ctn::navigation::ros1 {
namespace {

using namespace std::chrono_literals;

Odometry driving(std::chrono::nanoseconds stamp, double x) { return {stamp, {x, 2.0, 0.0}, {0.5, 0.0}}; }

TEST(OdometryHistory, GivesTheReadingOfTheInstant) {
  OdometryHistory history;
  for (int reading = 0; reading < 5; ++reading) history.add(driving(reading * 20ms, reading * 0.01));
  ASSERT_TRUE(history.at(60ms));
  EXPECT_EQ(history.at(60ms)->pose, (Pose{0.03, 2.0, 0.0}));
  EXPECT_EQ(history.at(60ms)->stamp, 60ms);
}

TEST(OdometryHistory, GoesOnFromTheNewestBeforeIt) {
  OdometryHistory history;
  history.add(driving(0ms, 1.0));
  history.add({20ms, {1.0, 2.0, 0.0}, {0.5, 1.0}});
  history.add(driving(100ms, 9.0));
  const auto odometry = history.at(40ms);
  ASSERT_TRUE(odometry);
  const Pose expected = along_arc({1.0, 2.0, 0.0}, 0.01, 0.02);
  EXPECT_EQ(odometry->stamp, 40ms);
  EXPECT_DOUBLE_EQ(odometry->pose.x, expected.x);
  EXPECT_DOUBLE_EQ(odometry->pose.y, expected.y);
  EXPECT_DOUBLE_EQ(odometry->pose.heading, 0.02);
  EXPECT_EQ(odometry->velocity, (Velocity{0.5, 1.0}));
}

TEST(OdometryHistory, KnowsNothingBeforeWhatItKeeps) {
  OdometryHistory history;
  EXPECT_FALSE(history.at(0ms));
  for (int reading = 0; reading < 20; ++reading) history.add(driving(reading * 20ms, 0.0));
  EXPECT_FALSE(history.at(60ms)) << "of the last 16 the first is at 80 ms";
  EXPECT_TRUE(history.at(80ms));
}

}  // namespace
}  // namespace ctn::navigation::ros1
