// For tests of messages.
#pragma once

#include <ros/serialization.h>

namespace ctn::navigation::ros1 {

// As a program of ROS would send and read it.
template <class Message>
Message over_the_wire(const Message& message) {
  const ros::SerializedMessage bytes = ros::serialization::serializeMessage(message);
  Message read;
  ros::serialization::deserializeMessage(bytes, read);
  return read;
}

}  // namespace ctn::navigation::ros1
