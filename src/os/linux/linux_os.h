// Linux behind the interface of os.h.
//
// Waiting is a futex (not a private one: words may lie in shared memory) with an absolute deadline of the monotonic
// clock. Levels are SCHED_FIFO priorities, see scheduling.h. A thread's CPU time is its kernel clock; for a thread of
// another process, to which the kernel denies that clock, it is /proc/TID/schedstat, which for a running thread lags by
// up to one scheduler tick and costs a few microseconds, most of them for opening it; a CpuClock keeps it open. How
// long a thread was ready to run without running is the second number of its schedstat file, which it keeps open; a
// kernel without CONFIG_SCHED_INFO does not tell. Topology and facts are read again at each call.
//
// spawn() throws std::system_error when the system has no thread left. A thread that it makes starts with the CPUs of
// the thread that made it. Thread safety and units: as os.h.
#pragma once

#include <memory>

#include "os/linux/files.h"
#include "os/os.h"

namespace ctn::os {

std::unique_ptr<Os> make_linux_os(LinuxRoots roots = {});

}  // namespace ctn::os
