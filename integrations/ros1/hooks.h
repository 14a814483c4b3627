// Between the two libraries of the port to ROS 1.
//
// libcatan_ros1_preload.so is loaded into every program that `catan ros run` starts, shells and Python among them. It
// needs nothing but the C library, takes the place of a few functions of roscpp and nodeletlib and passes them on.
// Where a program uses them and the environment has bindings, or a folder for what is observed, it loads
// libcatan_ros1.so, which has all the rest (and needs roscpp, which such a program has).
//
// Thread safety: as roscpp's own functions.
#pragma once

#include <ros/advertise_service_options.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/steady_timer_options.h>
#include <ros/subscribe_options.h>
#include <ros/timer_options.h>
#include <ros/wall_timer_options.h>
#include <sys/types.h>

#include <atomic>
#include <string>

namespace catan_ros {

// roscpp's own.
using Subscribe = ros::Subscriber (ros::NodeHandle::*)(ros::SubscribeOptions&);
using AdvertiseService = ros::ServiceServer (ros::NodeHandle::*)(ros::AdvertiseServiceOptions&);
using CreateTimer = ros::Timer (ros::NodeHandle::*)(ros::TimerOptions&) const;
using CreateWallTimer = ros::WallTimer (ros::NodeHandle::*)(ros::WallTimerOptions&) const;
using SerializeMessage = boost::function<ros::SerializedMessage(void)>;
using Publish = void (ros::Publisher::*)(const SerializeMessage&, ros::SerializedMessage&) const;
using CreateSteadyTimer = ros::SteadyTimer (ros::NodeHandle::*)(ros::SteadyTimerOptions&) const;

struct Hooks {
  // Each calls `next`, of the same handle, with options of its own where a binding names the callback.
  ros::Subscriber (*subscribe)(ros::NodeHandle& handle, ros::SubscribeOptions& options, Subscribe next);
  ros::ServiceServer (*advertise_service)(ros::NodeHandle& handle, ros::AdvertiseServiceOptions& options,
                                          AdvertiseService next);
  ros::Timer (*create_timer)(const ros::NodeHandle& handle, ros::TimerOptions& options, CreateTimer next);
  ros::WallTimer (*create_wall_timer)(const ros::NodeHandle& handle, ros::WallTimerOptions& options,
                                      CreateWallTimer next);
  ros::SteadyTimer (*create_steady_timer)(const ros::NodeHandle& handle, ros::SteadyTimerOptions& options,
                                          CreateSteadyTimer next);
  void (*publish)(const ros::Publisher& publisher, const SerializeMessage& serialize, ros::SerializedMessage& message,
                  Publish next);
  // The node whose run the calling thread is in; null: none. Good for ever.
  const char* (*current_node)();
  // The calling thread works for that node.
  void (*adopt)(const char* node);
  // That thread works for all nodes; null: nobody wants to know.
  void (*share)(pid_t thread);
  // ROS is shut down in this program.
  void (*shut_down)();

  // Whether any queue has bound callbacks, which is what the next four are for (turns_of_queues.h).
  const std::atomic<bool>* has_turns;
  // `in_loop`: a loop of the program's own waits in the queue. What enter() returns, leave() gets: whether that is
  // known.
  bool (*enter)(const ros::CallbackQueue* queue, bool in_loop);
  void (*leave)(const ros::CallbackQueue* queue, bool in_loop);
  // What end() gets; null: this queue has none.
  void* (*begin)(const ros::CallbackQueue* queue);
  void (*end)(void* begun);

  // A nodelet manager has a new queue, whose callbacks it calls one at a time or side by side, or gives one up; a
  // nodelet gets a queue (common/nodelet_queues.h).
  void (*add_nodelet_queue)(const ros::CallbackQueueInterface* queue, bool one_at_a_time);
  void (*remove_nodelet_queue)(const ros::CallbackQueueInterface* queue);
  void (*set_nodelet)(const ros::CallbackQueueInterface* queue, const std::string& nodelet);
  // Around a manager's call of a callback of such a queue; what the first returns the second gets.
  void* (*call_nodelet)(const ros::CallbackQueueInterface* queue);
  void (*called_nodelet)(void* taken);
};

}  // namespace catan_ros

// Of libcatan_ros1.so; null: the environment has nothing that it understands.
extern "C" const catan_ros::Hooks* catan_ros1_hooks();
