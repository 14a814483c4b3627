// Finds the server or session that schedules an app on this machine: a server by its socket, both by the memory of
// their flight recorder.
#pragma once

#include <string>

#include "base/result.h"
#include "flight/recording.h"
#include "os/os.h"
#include "runtime/control.h"

namespace ctn::tool {

// Where to reach a server that is named by its socket's path, an app file, or the name of the app.
// Errors: a file that is not an app file, a path at which there is no file.
Result<runtime::ServerAddress> address_of(const std::string& server);

// The recording of a server (named as above), or of a session, named by its app or the number of its process; an empty
// target: the only one there is. Errors: there is none, there are several, the server refuses.
Result<flight::Recording> attach(os::Clock& clock, const std::string& target);

// Moves the calling thread, and with it all that it starts later, to CPUs on which no node of the app may run, so that
// watching takes none of theirs. It stays where it is if there are no others, or where this is not allowed (in a
// container with fewer CPUs).
void keep_off_scheduled_cpus(os::Os& os, const os::CpuSet& scheduled);

}  // namespace ctn::tool
