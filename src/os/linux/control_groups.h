// The control groups that this process is in, from the top of the hierarchy down to its own.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "os/linux/files.h"

namespace ctn::os {

// Folders of the cgroups, the top first, the own one last; empty where the kernel has no such hierarchy. Where the path
// is the host's and not ours (in a container), the mount alone. `controller`: "cpu" for version 1, "" for version 2.
std::vector<std::string> cgroup_folders(const LinuxRoots& roots, std::string_view controller);

}  // namespace ctn::os
