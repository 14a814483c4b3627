// What a bound callback throws. It is called in its node's thread, where nobody of the program could catch it: it comes
// out of the spinner of the queue that the program asked for (ros::spinOnce(), callAvailable(), ...), as without Catan.
// What becomes of it there roscpp decides, or who calls the spinner.
//
// Thread safety: as the queue's.
#pragma once

#include <ros/callback_queue_interface.h>

#include <functional>

namespace catan_ros {

// Of the exception that is handled.
void hand_on_exception(ros::CallbackQueueInterface& queue);

// Makes the call, and hands on what it throws; `on_throw` is returned then.
template <class Result>
Result call_for(ros::CallbackQueueInterface& queue, const std::function<Result()>& call, Result on_throw) {
  try {
    return call();
  } catch (...) {
    hand_on_exception(queue);
    return on_throw;
  }
}

}  // namespace catan_ros
