// Judges what was observed of a Linux machine, together with what /proc and /sys say: one Finding a check, always the
// same checks in the same order, so that two machines can be compared line by line.
//
// Three files, by subject: whether real-time threads may run at all (checkup_permission.cpp), which CPUs there are and
// how fast (checkup_cpus.cpp), and how late things happen (checkup_time.cpp).
//
// Thread safety: pure functions of the file system and their arguments.
#pragma once

#include <vector>

#include "os/checkup.h"
#include "os/linux/files.h"

namespace ctn::os {

std::vector<Finding> judge(const LinuxRoots& roots, const Observed& observed);

// The parts of the above.
Finding check_permission(const LinuxRoots& roots, const Observed& observed);
Finding check_group(const LinuxRoots& roots, const Observed& observed);
Finding check_time_limit(const LinuxRoots& roots);
Finding check_slack(const LinuxRoots& roots, const Observed& observed);
Finding check_quota(const LinuxRoots& roots);

Finding check_cpus(const Observed& observed);
Finding check_capacity(const Observed& observed);
Finding check_smt(const LinuxRoots& roots, const Observed& observed);
Finding check_isolated(const LinuxRoots& roots, const Observed& observed);
Finding check_governor(const LinuxRoots& roots, const Observed& observed);
Finding check_frequency_limit(const LinuxRoots& roots, const Observed& observed);
Finding check_boost(const LinuxRoots& roots);
Finding check_idle(const LinuxRoots& roots, const Observed& observed);

Finding check_clock(const LinuxRoots& roots);
Finding check_timer(const Observed& observed);
Finding check_timer_slack(const LinuxRoots& roots, const Observed& observed);
Finding check_preemption(const LinuxRoots& roots);
Finding check_steal(const LinuxRoots& roots, const Observed& observed);

}  // namespace ctn::os
