#include "ros1/thrown.h"

#include <gtest/gtest.h>
#include <ros/callback_queue.h>

#include <stdexcept>

namespace catan_ros {
namespace {

TEST(Thrown, ComesOutOfTheProgramsSpinnerOnce) {
  ros::CallbackQueue queue;
  EXPECT_EQ(call_for<int>(
                queue, []() -> int { throw std::range_error("of the callback"); }, 7),
            7);
  EXPECT_THROW(queue.callAvailable(), std::range_error);
  EXPECT_NO_THROW(queue.callAvailable());
}

TEST(Thrown, WhatThrowsNothingIsCalledAlone) {
  ros::CallbackQueue queue;
  EXPECT_EQ(call_for<int>(
                queue, [] { return 3; }, 7),
            3);
  EXPECT_TRUE(queue.isEmpty());
}

}  // namespace
}  // namespace catan_ros
