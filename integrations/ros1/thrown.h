// What a bound callback throws. It is called in its node's thread, where nobody of the program could catch it: it comes
// out of the spinner of the queue that the program asked for (ros::spinOnce(), callAvailable(), ...), as without Catan.
// What becomes of it there roscpp decides, or who calls the spinner.
//
// Thread safety: as the callback's and the queue's.
#pragma once

#include <ros/callback_queue_interface.h>

#include <functional>

namespace catan_ros {

// The same callback; what it throws in a node's run is thrown by who calls from `queue`, which outlives it. In any
// other thread it throws as it does.
ros::CallbackInterfacePtr handing_on_exceptions(const ros::CallbackInterfacePtr& callback,
                                                ros::CallbackQueueInterface& queue);
// That of a timer, which a trigger calls.
std::function<bool()> handing_on_exceptions(std::function<bool()> call, ros::CallbackQueueInterface& queue);

}  // namespace catan_ros
