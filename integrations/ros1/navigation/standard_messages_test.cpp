#include "ros1/navigation/standard_messages.h"

#include <gtest/gtest.h>

#include <limits>

#include "ros1/navigation/testing/over_the_wire.h"

namespace ctn::navigation::ros1 {
namespace {

using namespace std::chrono_literals;

TEST(StandardMessages, AScanIsWhatItWas) {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  const Scan scan{12'345'678'901ns, std::numbers::pi, 30.0, {1.5F, kNothing, 0.25F, 29.0F, 3.0F}};
  const LaserScanMessage message = over_the_wire(to_message(scan));
  EXPECT_EQ(stamp_of(message), 12'345'678'901ns);
  EXPECT_FLOAT_EQ(message.angle_min, -static_cast<float>(std::numbers::pi) / 2.0F);
  EXPECT_FLOAT_EQ(message.angle_min + 4.0F * message.angle_increment, message.angle_max);
  const Scan read = scan_of(message);
  EXPECT_EQ(read.stamp, scan.stamp);
  EXPECT_EQ(read.ranges, scan.ranges);
  EXPECT_EQ(read.max_range, 30.0);
  for (std::size_t beam = 0; beam < 5; ++beam) EXPECT_NEAR(read.angle(beam), scan.angle(beam), 1e-6 * kDegree * 10.0);
}

TEST(StandardMessages, OdometryAndPosesAreWhatTheyWere) {
  for (const double heading : {0.0, 3.0, -3.0, 0.5, -1.25}) {
    const Odometry odometry{1001ms, {1.25, -7.5, heading}, {0.75, -1.5}};
    const Odometry read = odometry_of(over_the_wire(to_message(odometry)));
    EXPECT_EQ(read.stamp, odometry.stamp);
    EXPECT_EQ(position(read.pose), position(odometry.pose));
    EXPECT_NEAR(read.pose.heading, heading, 1e-12);
    EXPECT_EQ(read.velocity, odometry.velocity);
    const PoseMessage pose = over_the_wire(to_message(odometry.pose, 20ms));
    EXPECT_EQ(stamp_of(pose), 20ms);
    EXPECT_NEAR(pose_of(pose).heading, heading, 1e-12);
    EXPECT_EQ(pose.header.frame_id, "map");
  }
}

TEST(StandardMessages, AVelocityNamesItsScan) {
  const TwistMessage message = over_the_wire(to_message(Velocity{-0.1, 0.2}, 340ms));
  EXPECT_EQ(velocity_of(message), (Velocity{-0.1, 0.2}));
  EXPECT_EQ(stamp_of(message), 340ms);
}

// By what their types are called and summed, other programs know them.
TEST(StandardMessages, AreThoseOfRos) {
  EXPECT_STREQ(ros::message_traits::datatype<LaserScanMessage>(), "sensor_msgs/LaserScan");
  EXPECT_STREQ(ros::message_traits::md5sum<OdometryMessage>(), "cd5e73d190d741a2f92e81eda573aca7");
  EXPECT_TRUE(ros::message_traits::hasHeader<TwistMessage>());
}

}  // namespace
}  // namespace ctn::navigation::ros1
