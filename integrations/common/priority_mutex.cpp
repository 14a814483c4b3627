#include "common/priority_mutex.h"

#include <time.h>

namespace catan_ros {
namespace {

timespec to_timespec(std::chrono::nanoseconds since_epoch) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since_epoch);
  timespec time{};
  time.tv_sec = seconds.count();
  time.tv_nsec = (since_epoch - seconds).count();
  return time;
}

}  // namespace

PriorityMutex::PriorityMutex() {
  pthread_mutexattr_t attributes;
  ::pthread_mutexattr_init(&attributes);
  ::pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  ::pthread_mutex_init(&mutex_, &attributes);
  ::pthread_mutexattr_destroy(&attributes);
}

PriorityMutex::~PriorityMutex() { ::pthread_mutex_destroy(&mutex_); }
void PriorityMutex::lock() { ::pthread_mutex_lock(&mutex_); }
bool PriorityMutex::try_lock() { return ::pthread_mutex_trylock(&mutex_) == 0; }
void PriorityMutex::unlock() { ::pthread_mutex_unlock(&mutex_); }

bool PriorityMutex::try_lock_for(std::chrono::nanoseconds timeout) {
  const timespec until = to_timespec(std::chrono::system_clock::now().time_since_epoch() + timeout);
  return ::pthread_mutex_timedlock(&mutex_, &until) == 0;
}

PriorityCondition::PriorityCondition() {
  pthread_condattr_t attributes;
  ::pthread_condattr_init(&attributes);
  ::pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
  ::pthread_cond_init(&condition_, &attributes);
  ::pthread_condattr_destroy(&attributes);
}

PriorityCondition::~PriorityCondition() { ::pthread_cond_destroy(&condition_); }
void PriorityCondition::wait(PriorityMutex& mutex) { ::pthread_cond_wait(&condition_, &mutex.mutex_); }
void PriorityCondition::notify_all() { ::pthread_cond_broadcast(&condition_); }

bool PriorityCondition::wait_until(PriorityMutex& mutex, std::chrono::steady_clock::time_point until) {
  const timespec time = to_timespec(until.time_since_epoch());
  return ::pthread_cond_timedwait(&condition_, &mutex.mutex_, &time) == 0;
}

}  // namespace catan_ros
