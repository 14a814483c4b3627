// What decides how fast CPUs run, and what a hypervisor takes of them, from the kernel's small files.
//
// On mains: a power supply of type Mains that is online; where there is none, a battery says by charging or not. The
// batteries of devices (a mouse, a pen) do not count.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <map>

#include "os/linux/files.h"
#include "os/machine.h"

namespace ctn::os {

PowerState read_power_state(const LinuxRoots& roots, const CpuSet& cpus);
// By CPU, since boot; in steps of a jiffy, 10 ms as a rule.
std::map<int, Nanos> read_stolen_time(const LinuxRoots& roots);

}  // namespace ctn::os
