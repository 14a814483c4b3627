// Finds what schedules an app on this machine: a server by its socket, a server or a session by what it keeps in
// memory.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "flight/recording.h"
#include "os/os.h"

namespace ctn::tool {

// Where a server of a socket's path, an app file, or the name of an app may listen. kCaller: a file that is no app.
Result<std::vector<std::string>> sockets_of(const std::string& server);

// The last seconds of a server (as above), or of a session by its app or the number of its process; an empty target:
// of the only one there is. Errors: none, several, or what the server refuses.
Result<flight::Recording> attach(os::Clock& clock, const std::string& target);

}  // namespace ctn::tool
