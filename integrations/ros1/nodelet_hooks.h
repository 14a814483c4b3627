// What libcatan_ros1.so does where a nodelet manager's functions are called (hooks.h), and what it knows by that of the
// queue that a callback is to be called from: whose it is, and whose turn it is (common/nodelet_queues.h).
//
// Thread safety: all calls from any thread.
#pragma once

#include <ros/callback_queue_interface.h>

#include <string>

namespace catan_ros {

// A nodelet manager has a new queue, or gives one up.
void add_nodelet_queue(const ros::CallbackQueueInterface* queue, bool one_at_a_time);
void remove_nodelet_queue(const ros::CallbackQueueInterface* queue);
// It is of that nodelet, whose name need not be full. Null: of none.
void set_nodelet(const ros::CallbackQueueInterface* queue, const std::string& name);

// The nodelet's full name; empty: it is no nodelet's. A build that knows no nodelets says so, once, where a queue may
// be one's.
std::string nodelet_of(const ros::CallbackQueueInterface& queue);
// Whether that nodelet's queue calls one callback at a time.
bool calls_one_at_a_time(const ros::CallbackQueueInterface& queue);

}  // namespace catan_ros
