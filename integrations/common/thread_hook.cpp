#include "common/thread_hook.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>

#include "common/middleware_threads.h"
#include "common/new_threads.h"

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
  const catan_ros::ThreadHook* const hook = g_hook.load();
  const char* const node = hook != nullptr ? hook->current_node() : nullptr;
  const bool may_be_middlewares = catan_ros::may_make_middleware_thread(__builtin_return_address(0));
  return catan_ros::create_thread(kNext, thread, attributes, {function, argument, adopt_if_hooked, node},
                                  may_be_middlewares);
}
