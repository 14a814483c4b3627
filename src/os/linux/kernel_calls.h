// The kernel's calls about one thread's scheduling, bare: each returns 0 or an errno value. Virtual, so that a test can
// play a kernel that refuses, or that says yes and does nothing. None allocates or takes a lock, so the guardian makes
// them in the child of a fork.
//
// Thread safety: every call from any thread.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "os/os.h"

namespace ctn::os {

struct SchedulingPolicy {
  int policy = 0;  // SCHED_OTHER, SCHED_FIFO, ...
  int priority = 0;
  bool reset_on_fork = false;
  friend bool operator==(const SchedulingPolicy&, const SchedulingPolicy&) = default;
};

// CPUs as the kernel has them, a bit each: as many as Linux can be built for.
constexpr std::size_t kMaxCpus = 8192;
using CpuMask = std::array<std::uint64_t, kMaxCpus / 64>;

// Numbers that no CPU can have are left out.
CpuMask to_mask(const CpuSet& cpus);
CpuSet to_cpu_set(const CpuMask& mask);
CpuMask all_cpus();

class KernelCalls {
 public:
  virtual ~KernelCalls() = default;
  virtual int set_policy(pid_t thread, const SchedulingPolicy& policy);
  // The policy and the priority may be of two moments, if the thread is raised or lowered meanwhile.
  virtual int look_at_policy(pid_t thread, SchedulingPolicy& policy);
  // Of one moment. EAGAIN: it has not stayed for long enough.
  int get_policy(pid_t thread, SchedulingPolicy& policy);
  virtual int set_nice(pid_t thread, int nice);
  virtual int get_nice(pid_t thread, int& nice);
  // CPUs that are not there are ignored by the kernel as long as one is.
  virtual int set_affinity(pid_t thread, const CpuMask& cpus);
  // Of the CPUs the thread may use, the ones that are online.
  virtual int get_affinity(pid_t thread, CpuMask& cpus);
};

}  // namespace ctn::os
