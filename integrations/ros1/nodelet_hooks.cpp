#include "ros1/nodelet_hooks.h"

#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/names.h>

#include "ros1/turns_of_queues.h"

namespace catan_ros {
namespace {

#ifdef CATAN_NODELETLIB_LIBRARY
constexpr bool kKnowsNodelets = true;
#else
constexpr bool kKnowsNodelets = false;
#endif

void tell_of_missing_nodelets(const ros::CallbackQueueInterface& queue) {
  if (kKnowsNodelets || dynamic_cast<const ros::CallbackQueue*>(&queue) != nullptr) return;
  ROS_WARN_ONCE(
      "catan: a callback is to be called from a queue that is not roscpp's own, and this build knows no nodelets: "
      "nodelet: of a binding finds nothing, and bound callbacks of nodelets wait for their manager's threads; build "
      "Catan where nodelet/nodelet.h is (scripts/setup.sh --ros1)");
}

}  // namespace

void add_nodelet_queue(const ros::CallbackQueueInterface* queue, bool one_at_a_time) {
  nodelet_queues().add(queue, one_at_a_time);
}

void remove_nodelet_queue(const ros::CallbackQueueInterface* queue) { nodelet_queues().remove(queue); }

void set_nodelet(const ros::CallbackQueueInterface* queue, const std::string& name) {
  if (queue == nullptr || name.empty()) return;
  nodelet_queues().set_nodelet(queue, name.front() == '/' ? name : ros::names::resolve(name, false));
}

std::string nodelet_of(const ros::CallbackQueueInterface& queue) {
  tell_of_missing_nodelets(queue);
  return nodelet_queues().nodelet_of(&queue);
}

bool calls_one_at_a_time(const ros::CallbackQueueInterface& queue) {
  return nodelet_queues().calls_one_at_a_time(&queue);
}

}  // namespace catan_ros
