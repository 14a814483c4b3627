#include "common/thread_hook.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <memory>

namespace {

std::atomic<const catan_ros::ThreadHook*> g_hook{nullptr};

struct Helper {
  void* (*function)(void*);
  void* argument;
  const char* node;
};

void* run_helper(void* argument) {
  const std::unique_ptr<Helper> helper(static_cast<Helper*>(argument));
  if (const catan_ros::ThreadHook* const hook = g_hook.load()) hook->adopt(helper->node);
  return helper->function(helper->argument);
}

}  // namespace

extern "C" void catan_set_thread_hook(const catan_ros::ThreadHook* hook) { g_hook.store(hook); }

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*),
                              void* argument) noexcept {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto kNext = reinterpret_cast<Create>(::dlsym(RTLD_NEXT, "pthread_create"));
  const catan_ros::ThreadHook* const hook = g_hook.load();
  const char* const node = hook != nullptr ? hook->current_node() : nullptr;
  if (node == nullptr) return kNext(thread, attributes, function, argument);
  auto helper = std::make_unique<Helper>(Helper{function, argument, node});
  const int result = kNext(thread, attributes, run_helper, helper.get());
  if (result == 0) static_cast<void>(helper.release());
  return result;
}
