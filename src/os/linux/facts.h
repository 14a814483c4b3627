// What the kernel tells about itself and the machine: for the slack that plans need, and for the record of a run.
//
// Two mechanisms keep CPU time for ordinary threads. Kernels before 6.12 throttle real-time threads
// (sched_rt_runtime_us per sched_rt_period_us). Kernels from 6.12 on run a fair server on each CPU, whose numbers only
// debugfs shows; it is seldom readable, so the kernel's default (50 ms in 1 s) is assumed then, and said. Both can be
// at work at once, and a control group may throttle harder than the machine: the largest reserve counts.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <string>

#include "os/linux/files.h"
#include "os/machine.h"

namespace ctn::os {

struct Reserve {
  double fraction = 0.0;  // of each CPU, 0 to 1
  std::string by;         // as RealTimeFacts::reserved_by
};

Reserve read_reserve(const LinuxRoots& roots);
HostFacts read_host_facts(const LinuxRoots& roots);

}  // namespace ctn::os
