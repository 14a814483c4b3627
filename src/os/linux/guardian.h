// The Guardian of os.h on Linux: this process's side of it. guardian_process.h has the other.
//
// Guardian and server share a table of the watched threads. A thread counts as the same as long as its number and its
// start time are.
//
// Thread safety and units: as os.h.
#pragma once

#include <memory>

#include "base/result.h"
#include "os/linux/files.h"
#include "os/os.h"

namespace ctn::os {

// `roots` is where the guardian looks for start times, too.
Result<std::unique_ptr<Guardian>> start_guardian(const LinuxRoots& roots = {});

}  // namespace ctn::os
