// Where the programs of an app that one user starts share a file, such as which run sent a message.
//
// Thread safety: pure functions of the environment and the file system.
#pragma once

#include <string>

namespace ctn::tool {

// `socket`: of the server, an absolute path. Beside it, as SOCKET + `ending`, where this user can have a file of that
// name; else, as where root's server listens in /run, in a folder of this user's: XDG_RUNTIME_DIR, or /dev/shm. The
// same for all programs of one user and one socket. The file need not be there yet.
std::string shared_file_path(const std::string& socket, const std::string& ending);

}  // namespace ctn::tool
