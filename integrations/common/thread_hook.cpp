#include "common/thread_hook.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>

#include "common/helper_threads.h"
#include "common/middleware_threads.h"

namespace {

std::atomic<const catan_ros::ThreadHook*> g_hook{nullptr};

// The hook may have been taken away since the thread was made.
void adopt_if_hooked(const char* node) {
  if (const catan_ros::ThreadHook* const hook = g_hook.load()) hook->adopt(node);
}

}  // namespace

extern "C" void catan_set_thread_hook(const catan_ros::ThreadHook* hook) {
  g_hook.store(hook);
  catan_ros::set_share_thread(hook != nullptr ? hook->share : nullptr);
}

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*),
                              void* argument) noexcept {
  static const auto kNext = reinterpret_cast<catan_ros::CreateThread>(::dlsym(RTLD_NEXT, "pthread_create"));
  // Also in a node's run: the first one to need the middleware's thread has it made.
  if (catan_ros::may_make_middleware_thread(__builtin_return_address(0)) && catan_ros::makes_middleware_thread()) {
    return catan_ros::create_middleware_thread(kNext, thread, attributes, function, argument);
  }
  const catan_ros::ThreadHook* const hook = g_hook.load();
  const char* const node = hook != nullptr ? hook->current_node() : nullptr;
  if (node != nullptr) {
    return catan_ros::create_helper_thread(kNext, thread, attributes, {function, argument, node, adopt_if_hooked});
  }
  return kNext(thread, attributes, function, argument);
}
