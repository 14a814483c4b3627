// Where the server of an app listens, unless it is told otherwise.
//
// Thread safety: pure but for the environment, which must not be changed meanwhile.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace ctn::runtime {

// The environment variable that tells programs, and a server, where that is.
constexpr const char* kSocketVariable = "CATAN_SOCKET";

// For a server: CATAN_SOCKET if that is set; else /run/catan/APP.sock for root, XDG_RUNTIME_DIR/catan/APP.sock for
// others. kCaller: there is none.
Result<std::string> socket_to_serve(const std::string& app);

// For a client, most likely first: CATAN_SOCKET alone if that is set, else both others. kCaller: no app is named and
// CATAN_SOCKET is not set.
Result<std::vector<std::string>> sockets_to_try(const std::string& app);

// For who controls the server of the app with this name: all that there are, that of CATAN_SOCKET first. Which app is
// scheduled there it has to ask (control.h).
std::vector<std::string> sockets_of_app(const std::string& app);

}  // namespace ctn::runtime
