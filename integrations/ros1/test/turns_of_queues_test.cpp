#include "ros1/turns_of_queues.h"

#include <gtest/gtest.h>

namespace catan_ros {
namespace {

TEST(TurnsOfQueue, ALoopThatWaitsIsWokenOnceAtATime) {
  ros::CallbackQueue queue;
  TurnsOfQueue turns;
  turns.begin_loop();
  turns.wake_loop(queue);
  turns.wake_loop(queue);
  EXPECT_EQ(queue.callOne(), ros::CallbackQueue::Called);
  EXPECT_EQ(queue.callOne(), ros::CallbackQueue::Empty);
  turns.wake_loop(queue);
  EXPECT_FALSE(queue.isEmpty()) << "and the next time again";
  queue.clear();
  turns.wake_loop(queue);
  EXPECT_FALSE(queue.isEmpty()) << "also where nobody called that";
}

TEST(TurnsOfQueue, WhereNoLoopWaitsThereIsNothingToCall) {
  ros::CallbackQueue queue;
  TurnsOfQueue turns;
  turns.wake_loop(queue);
  EXPECT_TRUE(queue.isEmpty());
  turns.begin_loop();
  turns.end_loop();
  turns.wake_loop(queue);
  EXPECT_TRUE(queue.isEmpty());
}

}  // namespace
}  // namespace catan_ros
