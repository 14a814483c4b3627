// Why the kernel would not let a thread become real-time, and what to do about it: the privilege itself, or the budget
// that a control group (version 1) sets for its real-time threads, in microseconds per period.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "os/linux/files.h"

namespace ctn::os {

// Of os::kHighestLevel, under SCHED_FIFO: what RLIMIT_RTPRIO has to allow.
constexpr int kHighestPriority = 70;

struct RealTimeCgroup {
  std::string file;  // where the budget is set
  std::int64_t runtime_us = 0;
  std::int64_t period_us = 1'000'000;
};

// The cgroup of this process, where the kernel budgets real-time threads by cgroup.
std::optional<RealTimeCgroup> real_time_cgroup(const LinuxRoots& roots);

// Whether this process has the privilege that lets root set any scheduling.
bool has_cap_sys_nice(const LinuxRoots& roots);

// Of this process; "PROGRAM" where it cannot be told.
std::string program_path(const LinuxRoots& roots);

// What the user can do after an EPERM; one sentence.
std::string how_to_permit(const LinuxRoots& roots);

}  // namespace ctn::os
