// Gives one thread back the scheduling that it had: the only place that does, for this process and for its guardian.
//
// Nothing here allocates, takes a lock or throws: the guardian calls it in the child of a fork. Units: in the names.
// Thread safety: as that of the KernelCalls.
#pragma once

#include <cstdint>

#include "os/linux/kernel_calls.h"
#include "os/os.h"

namespace ctn::os {

// SavedScheduling with all of it in place, so that processes can share it.
struct SavedThread {
  ThreadId thread{};
  std::uint64_t started = 0;  // jiffies since the system's start (process.h)
  SchedulingPolicy policy;
  int nice = 0;
  CpuMask cpus{};  // none: they are left alone
};

SavedThread to_saved_thread(const SavedScheduling& saved);

// What became of each part: 0, or the errno value of the call that was refused.
struct RestoreErrors {
  int policy = 0;
  int nice = 0;
  int cpus = 0;
  // What the thread has now if `policy` is 0 and the kernel keeps its word: what was saved, or that with the flag,
  // which an unprivileged process cannot clear. It changes nothing for the thread itself.
  SchedulingPolicy given;
};

// Tries every part, so that one refusal leaves as little behind as can be. Of the CPUs that were saved the thread gets
// the ones that are still there; when none is, all. A thread that is gone, or is another by now, is ESRCH and not
// touched. `procfs` is where start times are looked up.
RestoreErrors restore(KernelCalls& kernel, const char* procfs, const SavedThread& saved);

}  // namespace ctn::os
