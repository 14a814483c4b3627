// What the libraries do that stand in for pthread_create: whom a new thread works for is said by the thread itself,
// before it does anything else. One that a middleware makes for itself works for all nodes of the program
// (middleware_threads.h); one that a node's callback makes (a pool of its own, OpenMP's, OpenCV's) for its node; any
// other is as it would be without the library.
//
// It needs nothing but the C library, since it is part of what is loaded into programs. Thread safety: any thread.
#pragma once

#include <pthread.h>

namespace catan_ros {

using CreateThread = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);

struct NewThread {
  void* (*function)(void*);
  void* argument;
  void (*hook)(const char* node);  // called by the thread before its function
  const char* node;                // what the hook is called with; null: no node
};

// `create` is the C library's pthread_create. Returns what that does.
int create_hooked_thread(CreateThread create, pthread_t* thread, const pthread_attr_t* attributes,
                         const NewThread& todo);

// Chooses among the three. `of_node`: with the node in whose run the caller is (null: none), and what a thread calls
// that works for it. `may_be_middlewares`: else it is not looked for who makes the thread.
int create_thread(CreateThread create, pthread_t* thread, const pthread_attr_t* attributes, const NewThread& of_node,
                  bool may_be_middlewares);

}  // namespace catan_ros
