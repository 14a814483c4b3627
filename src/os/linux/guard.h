// The Guard of os.h on Linux: this process's side of it. guardian.h has the other.
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
Result<std::unique_ptr<Guard>> start_guard(const LinuxRoots& roots = {});

}  // namespace ctn::os
