// libcatan_threads.so: pthread_create, found before the C library's where this is preloaded. A thread that a node's run
// makes (a pool of OpenCV's, of a plugin's own) works for that node: the port, which says whose run a thread is in, is
// told so by the new thread before it does anything else. One that a middleware makes for itself works for all nodes of
// the program (middleware_threads.h). It needs nothing but the C library.
//
// Thread safety: all calls from any thread.
#pragma once

#include <sys/types.h>

namespace catan_ros {

struct ThreadHook {
  // The node whose run the calling thread is in; null: none. Good for as long as the hook is set.
  const char* (*current_node)();
  // The calling thread works for that node.
  void (*adopt)(const char* node);
  // That thread works for all nodes; null: nobody wants to know.
  void (*share)(pid_t thread);
};

// What a port looks up, to see whether the library is there.
inline constexpr const char* kSetThreadHook = "catan_set_thread_hook";
using SetThreadHook = void (*)(const ThreadHook* hook);

}  // namespace catan_ros

// Null: none any more. `hook` lives until another one is set.
extern "C" void catan_set_thread_hook(const catan_ros::ThreadHook* hook);
