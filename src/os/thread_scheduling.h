// How threads are scheduled: at which level, on which CPUs, and back to what they had.
//
// Thread safety: any thread at any time. Cost: shift_level() is one system call.
#pragma once

#include <cstdint>
#include <memory>

#include "base/result.h"
#include "os/cpu_set.h"
#include "os/level.h"
#include "os/threads.h"

namespace ctn::os {

// A thread, and its scheduling as it was before Catan touched it. Only the implementation that made it can read it.
struct SavedScheduling {
  ThreadId thread{};
  std::uint64_t started = 0;  // when: tells the thread from a later one that has its number
  int policy = 0;
  int priority = 0;
  int nice = 0;
  bool reset_on_fork = false;
  CpuSet affinity;

  bool same_thread(const SavedScheduling& other) const { return thread == other.thread && started == other.started; }
  friend bool operator==(const SavedScheduling&, const SavedScheduling&) = default;
};

// Gives threads of other processes their scheduling back if this process ends without doing so itself, however it ends:
// a second process, the guardian, outlives it for as long as that takes. It does not touch watched threads before that.
//
// Start it early: what this process has in memory by then the guardian keeps, too. It cannot help where it is killed
// together with this process. Thread safety: every call from any thread.
class Guardian {
 public:
  // Ends the guardian, which restores what has not been forgotten.
  virtual ~Guardian() = default;

  // From now on the thread would get back `before`; of several calls the last counts. False, and then it would not:
  // the thread is gone, too many are watched (1024), or no guardian can be had.
  virtual bool watch(const SavedScheduling& before) = 0;
  // For a thread that got its scheduling back, or ended. Nothing happens where it is not watched.
  virtual void forget(ThreadId thread) = 0;

  // Where another program ended the guardian, starts another in its place, which watches what it did. Cheap enough to
  // be called every second; watch() calls it, too. kEnvironment: none can be started; the next call tries again.
  virtual Status ensure_running() = 0;
  // How often that was needed: what a user should be told when it grows.
  virtual int replaced() const = 0;
};

class ThreadScheduling {
 public:
  virtual ~ThreadScheduling() = default;

  // Sets, reads back, and fails (kEnvironment) unless the thread then has the level or CPUs that were asked for. What
  // the thread creates later does not inherit a real-time level.
  virtual Status set_level(ThreadId thread, Level level) = 0;
  // The same for a controller, which has no time to look and none to report to: one system call, no answer. For a
  // thread whose level was set with set_level() before; what was refused then is refused now.
  virtual void shift_level(ThreadId thread, Level level) = 0;
  virtual Result<Level> level(ThreadId thread) = 0;
  virtual Status set_affinity(ThreadId thread, const CpuSet& cpus) = 0;
  virtual Result<CpuSet> affinity(ThreadId thread) = 0;
  virtual Result<SavedScheduling> save_scheduling(ThreadId thread) = 0;
  // Whether it is what set_level() gives a thread, at a level above ordinary. Real-time threads of a program's own
  // seldom look so.
  virtual bool is_raised(const SavedScheduling& saved) const = 0;
  // kEnvironment: something was refused, or the thread is gone. Another that has its number by now is not touched.
  virtual Status restore_scheduling(const SavedScheduling& saved) = 0;

  // kEnvironment where the system has no process left, or forbids what a guardian needs. Ended before this object.
  virtual Result<std::unique_ptr<Guardian>> start_guardian() = 0;
};

}  // namespace ctn::os
