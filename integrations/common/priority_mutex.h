// A mutex with priority inheritance, and a condition to wait for with it: the thread that holds it runs at least at the
// level of those that wait for it. Nodes of different levels, and threads of the framework's own, share what it guards;
// an ordinary mutex would let a thread of a middle level keep a high one waiting for as long as it likes.
//
// Units: std::chrono; waits end by the monotonic clock, locks that give up by the system's clock, which is the one that
// such mutexes know everywhere. Thread safety: all calls from any thread; unlock() by the thread that holds it.
#pragma once

#include <pthread.h>

#include <chrono>

namespace catan_ros {

class PriorityMutex {
 public:
  PriorityMutex();
  ~PriorityMutex();
  PriorityMutex(const PriorityMutex&) = delete;
  PriorityMutex& operator=(const PriorityMutex&) = delete;

  void lock();
  bool try_lock();
  bool try_lock_for(std::chrono::nanoseconds timeout);
  void unlock();

 private:
  friend class PriorityCondition;
  pthread_mutex_t mutex_;
};

class PriorityCondition {
 public:
  PriorityCondition();
  ~PriorityCondition();
  PriorityCondition(const PriorityCondition&) = delete;
  PriorityCondition& operator=(const PriorityCondition&) = delete;

  // Precondition: the calling thread holds `mutex`.
  void wait(PriorityMutex& mutex);
  // False: the time was up.
  bool wait_until(PriorityMutex& mutex, std::chrono::steady_clock::time_point until);
  void notify_all();

 private:
  pthread_cond_t condition_;
};

}  // namespace catan_ros
