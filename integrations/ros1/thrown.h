// What a bound callback throws (common/thrown.h) comes out of the spinner of the queue that the program asked for
// (ros::spinOnce(), callAvailable(), ...), as without Catan.
//
// Thread safety: as the callback's and the queue's.
#pragma once

#include <ros/callback_queue_interface.h>

#include <functional>

#include "common/inbox.h"

namespace catan_ros {

// The call of that callback, and what came of it; what it throws in a node's run is thrown by who calls from `queue`,
// which outlives the call. In any other thread it throws as it does.
std::function<Outcome()> handing_on_exceptions(ros::CallbackInterfacePtr callback, ros::CallbackQueueInterface& queue);
// That of a timer, which a trigger calls.
std::function<bool()> handing_on_exceptions(std::function<bool()> call, ros::CallbackQueueInterface& queue);

}  // namespace catan_ros
