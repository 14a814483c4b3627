// Keeping the idle CPUs of a virtual machine from being given away, by the kernel's power-management interface: as long
// as /dev/cpu_dma_latency is held open with a value of 0, idle CPUs poll for work instead of halting.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <memory>

#include "base/result.h"
#include "os/linux/files.h"
#include "os/machine.h"

namespace ctn::os {

// As Machine::keep_cpus_ready. A virtual machine is known by its idle driver, "haltpoll", which is made for guests.
Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready(const LinuxRoots& roots);

}  // namespace ctn::os
