// A thread that a node's callback makes (a pool of its own, OpenMP's, OpenCV's) works for its node: what the libraries
// do that stand in for pthread_create.
//
// Thread safety: any thread.
#pragma once

#include <pthread.h>

#include <memory>

namespace catan_ros {

using CreateThread = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);

struct HelperThread {
  void* (*function)(void*);
  void* argument;
  const char* node;
  void (*adopt)(const char* node);  // called by the thread before all else
};

inline void* run_helper_thread(void* helper) {
  const std::unique_ptr<HelperThread> owned(static_cast<HelperThread*>(helper));
  const HelperThread todo = *owned;
  todo.adopt(todo.node);
  return todo.function(todo.argument);
}

// `create` is the C library's pthread_create. Returns what that does.
inline int create_helper_thread(CreateThread create, pthread_t* thread, const pthread_attr_t* attributes,
                                const HelperThread& todo) {
  auto helper = std::make_unique<HelperThread>(todo);
  const int result = create(thread, attributes, run_helper_thread, helper.get());
  if (result == 0) static_cast<void>(helper.release());
  return result;
}

}  // namespace catan_ros
