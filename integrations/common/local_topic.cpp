#include "common/local_topic.h"

#include <mutex>

namespace catan_ros {

void LocalTopic::add(LocalCallback& callback) {
  const std::lock_guard lock(mutex_);
  callbacks_.push_back(&callback);
}

// Before it is sent, so that who gets it finds the run.
void LocalTopic::publishing(const void* message) {
  if (LocalNode* const node = LocalNode::current()) {
    node->note_sent(MessageRuns::key_of_address(name_, message));
  }
  const std::lock_guard lock(mutex_);
  for (LocalCallback* const callback : callbacks_) callback->expect(message);
}

void LocalTopic::published(const std::shared_ptr<const void>& message) {
  if (message) {
    const std::lock_guard lock(mutex_);
    for (LocalCallback* const callback : callbacks_) callback->deliver(message);
  }
  if (LocalNode* const node = LocalNode::current()) node->note_published(name_);
}

void LocalTopic::taken(const void* message) {
  if (LocalNode* const node = LocalNode::current()) node->note_taken(MessageRuns::key_of_address(name_, message));
}

}  // namespace catan_ros
