// Levels and affinity of threads on Linux: set, then read back, then believed.
//
// kOrdinary is SCHED_OTHER with the nice value that the thread has; the others are SCHED_FIFO 1 to 4, in their order,
// and fixed levels SCHED_FIFO from 5 on.
// All carry SCHED_RESET_ON_FORK, so that what a thread makes starts ordinary. An unprivileged process can set that flag
// but not clear it: restore() leaves it set then (restore.h).
//
// Thread safety: as that of the KernelCalls, which must outlive this.
#pragma once

#include <string>
#include <utility>

#include "os/linux/files.h"
#include "os/linux/kernel_calls.h"
#include "os/os.h"

namespace ctn::os {

class Scheduling {
 public:
  Scheduling(LinuxRoots roots, KernelCalls& calls) : roots_(std::move(roots)), calls_(calls) {}

  Status set_level(ThreadId thread, Level level);
  void shift_level(ThreadId thread, Level level);
  // Whether all levels are permitted: the thread gets the highest, and is at the ordinary one afterwards.
  Status try_levels(ThreadId thread);
  Result<Level> level(ThreadId thread);
  Status set_affinity(ThreadId thread, const CpuSet& cpus);
  Result<CpuSet> affinity(ThreadId thread);
  // Fails on a SCHED_DEADLINE thread: its parameters could not be given back.
  Result<SavedScheduling> save(ThreadId thread);
  static bool is_raised(const SavedScheduling& saved);
  // Of the CPUs that were saved, the ones that are still there; when none is, all.
  Status restore(const SavedScheduling& saved);

 private:
  Status set_policy(ThreadId thread, const SchedulingPolicy& policy, const std::string& what);
  // Whether the thread has what the kernel was asked to give it.
  Status check_policy(ThreadId thread, const SchedulingPolicy& policy, const std::string& what);
  // The error for an errno value of a call that was to do `what`.
  Error refused(ThreadId thread, const std::string& what, int error) const;

  LinuxRoots roots_;
  KernelCalls& calls_;
};

}  // namespace ctn::os
