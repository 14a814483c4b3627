// The CPUs of a machine from sysfs. CPUs without a topology folder (offline ones) count as a core of their own, with a
// negative number that no other CPU has.
//
// Thread safety: pure function of the file system.
#pragma once

#include "os/linux/files.h"
#include "os/machine.h"

namespace ctn::os {

// Fails (kEnvironment) only when sysfs shows no CPU at all.
Result<Topology> read_topology(const LinuxRoots& roots);
// By one file, where the kernel has it.
Result<CpuSet> read_online_cpus(const LinuxRoots& roots);

}  // namespace ctn::os
