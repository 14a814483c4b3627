// Threads that a middleware makes for itself (roscpp's network and timers, DDS's receivers) work for all nodes of the
// program. They are known by who makes them: the first caller of pthread_create() that is no library for threads. A
// nodelet manager's are none: they call the nodelets' callbacks.
//
// In its library's own thread each says so to the port, as soon as there is one; it needs nothing but the C library,
// since it is part of what is loaded into programs.
//
// Thread safety: any thread.
#pragma once

#include <sys/types.h>

#include <string_view>

namespace catan_ros {

// Of a caller: the file that its code is from, without folders, and the name of its function, mangled, where it has
// one.
struct Caller {
  std::string_view library;
  std::string_view function;
};

enum class Maker {
  kThreadLibrary,  // who has called that?
  kMiddleware,     // for itself
  kOther,          // a program, or a middleware for it: its spinners
};
Maker maker_of(const Caller& caller);

// Whether the thread that the calling function makes is a middleware's. Callers in the file of this function do not
// count.
bool makes_middleware_thread();
// Whether it may be, by the place that calls pthread_create alone: most threads are told by that.
bool may_make_middleware_thread(const void* caller);

// What is called by each such thread, with its number, when it begins; those that began before, and
// run, are told at once. It must not wait: a middleware may wait until its thread has begun.
using ShareThread = void (*)(pid_t thread);
void set_share_thread(ShareThread share);

// What each such thread calls when it begins (NewThread::hook). It counts as one until it ends.
void note_middleware_thread(const char* node);

}  // namespace catan_ros
