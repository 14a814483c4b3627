// Finds the flight recorders (recorder.h) of running processes, sessions and servers alike, through /proc. A user finds
// those of processes that the user may trace: their own, of programs without file capabilities. Root finds all.
//
// Thread safety: pure functions of the system's state.
#pragma once

#include <string>

#include "base/result.h"
#include "os/linux/descriptor.h"

namespace ctn::flight {

// The memory of the flight recorder of that app, by its name, or of the process with that number; empty: of the only
// one there is.
// Errors: none, several (kCaller).
Result<os::Descriptor> find(const std::string& app_or_process);

}  // namespace ctn::flight
