// Restores a thread's scheduling at the end of a scope, however the scope ends.
//
//   SchedulingGuard guard(os, thread);          // remembers policy, priority, nice and affinity
//   if (!guard.status().ok()) return guard.status();
//   os.set_level(thread, Level::kActive); ...   // undone at the end of the scope, or by guard.restore()
//
// A thread that has ended by then needs nothing, so the destructor ignores errors: a caller that wants them calls
// restore().
// Thread safety: one guard is used by one thread at a time; the guarded thread may be another.
#pragma once

#include <utility>

#include "os/thread_scheduling.h"

namespace ctn::os {

class SchedulingGuard {
 public:
  // `scheduling` outlives the guard.
  SchedulingGuard(ThreadScheduling& scheduling, ThreadId thread)
      : scheduling_(scheduling), saved_(scheduling.save_scheduling(thread)) {}
  ~SchedulingGuard() { static_cast<void>(restore()); }
  SchedulingGuard(const SchedulingGuard&) = delete;
  SchedulingGuard& operator=(const SchedulingGuard&) = delete;

  // Whether the scheduling could be saved. If not, nothing will be restored.
  Status status() const { return saved_.ok() ? Status(Done{}) : Status(saved_.error()); }

  // Restores now; the destructor then does nothing. Does nothing the second time.
  Status restore() {
    if (!saved_.ok() || std::exchange(restored_, true)) return Done{};
    return scheduling_.restore_scheduling(saved_.value());
  }

 private:
  ThreadScheduling& scheduling_;
  Result<SavedScheduling> saved_;
  bool restored_ = false;
};

}  // namespace ctn::os
