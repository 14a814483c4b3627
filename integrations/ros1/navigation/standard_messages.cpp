#include "ros1/navigation/standard_messages.h"

#include <cmath>
#include <cstdint>

namespace ctn::navigation::ros1 {
namespace {

template <class Message>
void set_header(Message& message, std::chrono::nanoseconds stamp, const char* frame) {
  message.header.stamp.fromNSec(static_cast<std::uint64_t>(stamp.count()));
  message.header.frame_id = frame;
}

template <class PoseOfMessage>
void set_pose(PoseOfMessage& message, const Pose& pose) {
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation.z = std::sin(pose.heading / 2.0);
  message.orientation.w = std::cos(pose.heading / 2.0);
}

template <class PoseOfMessage>
Pose planar_pose(const PoseOfMessage& message) {
  return {message.position.x, message.position.y,
          wrapped(2.0 * std::atan2(message.orientation.z, message.orientation.w))};
}

}  // namespace

LaserScanMessage to_message(const Scan& scan) {
  LaserScanMessage message;
  set_header(message, scan.stamp, "base_link");
  const auto half = static_cast<float>(scan.field / 2.0);
  message.angle_min = -half;
  message.angle_max = half;
  if (scan.ranges.size() > 1) message.angle_increment = 2.0F * half / static_cast<float>(scan.ranges.size() - 1);
  message.range_max = static_cast<float>(scan.max_range);
  message.ranges.assign(scan.ranges.begin(), scan.ranges.end());
  return message;
}

OdometryMessage to_message(const Odometry& odometry) {
  OdometryMessage message;
  set_header(message, odometry.stamp, "odom");
  message.child_frame_id = "base_link";
  set_pose(message.pose.pose, odometry.pose);
  message.twist.twist.linear.x = odometry.velocity.linear;
  message.twist.twist.angular.z = odometry.velocity.angular;
  return message;
}

TwistMessage to_message(const Velocity& velocity, std::chrono::nanoseconds stamp) {
  TwistMessage message;
  set_header(message, stamp, "base_link");
  message.twist.linear.x = velocity.linear;
  message.twist.angular.z = velocity.angular;
  return message;
}

PoseMessage to_message(const Pose& pose, std::chrono::nanoseconds stamp) {
  PoseMessage message;
  set_header(message, stamp, "map");
  set_pose(message.pose, pose);
  return message;
}

Scan scan_of(const LaserScanMessage& message) {
  Scan scan;
  scan.stamp = stamp_of(message);
  scan.field = static_cast<double>(message.angle_max) - static_cast<double>(message.angle_min);
  scan.max_range = static_cast<double>(message.range_max);
  scan.ranges.assign(message.ranges.begin(), message.ranges.end());
  return scan;
}

Odometry odometry_of(const OdometryMessage& message) {
  return {stamp_of(message), planar_pose(message.pose.pose),
          Velocity{message.twist.twist.linear.x, message.twist.twist.angular.z}};
}

Velocity velocity_of(const TwistMessage& message) { return {message.twist.linear.x, message.twist.angular.z}; }

Pose pose_of(const PoseMessage& message) { return planar_pose(message.pose); }

}  // namespace ctn::navigation::ros1
