// Judges what was observed of a Linux machine, together with what /proc and /sys say: one Finding a check, always the
// same checks in the same order, so that two machines can be compared line by line.
//
// Three files, by subject: whether real-time threads may run at all (checks_permission.cpp), which CPUs there are and
// how fast (checks_cpus.cpp), and how late things happen (checks_time.cpp).
//
// Thread safety: pure functions of the file system and their arguments.
#pragma once

#include <vector>

#include "doctor/checkup.h"
#include "os/linux/files.h"

namespace ctn::doctor {

std::vector<Finding> judge(const os::LinuxRoots& roots, const Observed& observed);

// The parts of the above.
Finding check_permission(const os::LinuxRoots& roots, const Observed& observed);
Finding check_cgroup(const os::LinuxRoots& roots, const Observed& observed);
Finding check_time_limit(const os::LinuxRoots& roots);
Finding check_slack(const os::LinuxRoots& roots, const Observed& observed);
Finding check_quota(const os::LinuxRoots& roots);

Finding check_cpus(const Observed& observed);
Finding check_capacity(const Observed& observed);
Finding check_smt(const os::LinuxRoots& roots, const Observed& observed);
Finding check_isolated(const os::LinuxRoots& roots, const Observed& observed);
Finding check_governor(const os::LinuxRoots& roots, const Observed& observed);
Finding check_frequency_limit(const os::LinuxRoots& roots, const Observed& observed);
Finding check_boost(const os::LinuxRoots& roots);
Finding check_idle(const os::LinuxRoots& roots, const Observed& observed);

Finding check_clock(const os::LinuxRoots& roots);
Finding check_timer(const Observed& observed);
Finding check_timer_slack(const os::LinuxRoots& roots, const Observed& observed);
Finding check_preemption(const os::LinuxRoots& roots);
Finding check_steal(const os::LinuxRoots& roots, const Observed& observed);

}  // namespace ctn::doctor
