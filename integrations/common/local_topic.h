// A topic in a program whose nodes share messages: which run sent a message, which takes it, and whom it goes to.
//
// Thread safety: all calls from any thread. A mutex with priority inheritance is held for as long as it takes to put a
// pointer into the inboxes of the topic's callbacks.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/local_callback.h"
#include "common/local_hooks.h"
#include "common/priority_mutex.h"

namespace catan_ros {

class LocalTopic final : public TopicHook {
 public:
  explicit LocalTopic(std::string name) : name_(std::move(name)) {}

  // `callback` outlives it.
  void add(LocalCallback& callback);

  void publishing(const void* message) override;
  void published(const std::shared_ptr<const void>& message) override;
  void taken(const void* message) override;

 private:
  const std::string name_;
  PriorityMutex mutex_;
  std::vector<LocalCallback*> callbacks_;
};

}  // namespace catan_ros
