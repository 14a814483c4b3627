// rcl's functions that publish, found before rcl's own where a program is linked with libcatan_ros2.so: so a node's run
// is known to have given output. They do what rcl's do, and return what these return.
//
// Thread safety: as rcl's.
#include <dlfcn.h>
#include <rcl/publisher.h>

#include "common/local_node.h"

namespace {

template <class Function>
Function* rcls_own(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

rcl_ret_t noted(const rcl_publisher_t* publisher, rcl_ret_t result) {
  catan_ros::LocalNode* const node = catan_ros::LocalNode::current();
  if (node == nullptr || result != RCL_RET_OK) return result;
  if (const char* const topic = rcl_publisher_get_topic_name(publisher)) node->note_published(topic);
  return result;
}

}  // namespace

extern "C" {

rcl_ret_t rcl_publish(const rcl_publisher_t* publisher, const void* message, rmw_publisher_allocation_t* allocation) {
  static auto* const kOwn = rcls_own<decltype(rcl_publish)>("rcl_publish");
  return noted(publisher, kOwn(publisher, message, allocation));
}

rcl_ret_t rcl_publish_serialized_message(const rcl_publisher_t* publisher, const rcl_serialized_message_t* message,
                                         rmw_publisher_allocation_t* allocation) {
  static auto* const kOwn = rcls_own<decltype(rcl_publish_serialized_message)>("rcl_publish_serialized_message");
  return noted(publisher, kOwn(publisher, message, allocation));
}

rcl_ret_t rcl_publish_loaned_message(const rcl_publisher_t* publisher, void* message,
                                     rmw_publisher_allocation_t* allocation) {
  static auto* const kOwn = rcls_own<decltype(rcl_publish_loaned_message)>("rcl_publish_loaned_message");
  return noted(publisher, kOwn(publisher, message, allocation));
}

}  // extern "C"
