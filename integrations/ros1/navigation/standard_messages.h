// ROS's own messages at the robot's border, from and to the app's values: what a simulator, a real robot or rviz deals
// in.
//
// A LaserScan's angles are single precision, so that its beams are off by less than a millionth of a degree. Times are
// those of the robot's world, which begin at 0.
//
// Generated headers of Debian's messages take an allocator of before C++20: theirs is Rebinding here.
//
// Units: as the values; in messages seconds. Thread safety: pure functions.
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>

#include <chrono>
#include <memory>

#include "geometry.h"
#include "sensors.h"

namespace ctn::navigation::ros1 {

// What messages ask of an allocator, which the standard has removed since.
template <class T>
struct Rebinding : std::allocator<T> {
  Rebinding() = default;
  template <class Other>
  Rebinding(const Rebinding<Other>& /*other*/) {}  // NOLINT(google-explicit-constructor): as std::allocator's
  template <class Other>
  struct rebind {                    // NOLINT(readability-identifier-naming): as messages call it
    using other = Rebinding<Other>;  // NOLINT(readability-identifier-naming)
  };
};

using LaserScanMessage = sensor_msgs::LaserScan_<Rebinding<void>>;
using OdometryMessage = nav_msgs::Odometry_<Rebinding<void>>;
using TwistMessage = geometry_msgs::TwistStamped_<Rebinding<void>>;
using PoseMessage = geometry_msgs::PoseStamped_<Rebinding<void>>;

LaserScanMessage to_message(const Scan& scan);
OdometryMessage to_message(const Odometry& odometry);
TwistMessage to_message(const Velocity& velocity, std::chrono::nanoseconds stamp);
PoseMessage to_message(const Pose& pose, std::chrono::nanoseconds stamp);

Scan scan_of(const LaserScanMessage& message);
Odometry odometry_of(const OdometryMessage& message);
Velocity velocity_of(const TwistMessage& message);
Pose pose_of(const PoseMessage& message);
template <class Message>
std::chrono::nanoseconds stamp_of(const Message& message) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(message.header.stamp.toNSec()));
}

}  // namespace ctn::navigation::ros1
