// What controls a server from outside (`catan ctl`): one question over its socket (protocol.h), and its answer.
//
// Thread safety: any thread; each call makes a connection of its own. Cost: each call may wait for two seconds.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "catan/changes.h"
#include "os/linux/shared_memory.h"
#include "os/os.h"

namespace ctn::runtime {

// Which server is meant.
struct ServerAddress {
  std::vector<std::string> sockets;
  // The name of the app that it schedules; empty: any. Others that listen at these sockets (CATAN_SOCKET may be of
  // another app) are passed over, and so are those that do not say what they schedule, as one of another user or
  // version.
  std::string app{};
};

// The first server that is meant, of those that listen at the sockets, is asked. Errors: what the server refuses
// (kCaller); no server, one that does not answer or is of another version (kEnvironment).
Status ask_to_change(os::Clock& clock, const ServerAddress& server, const Changes& changes);
// As the server describes itself: JSON.
Result<std::string> ask_for_status(os::Clock& clock, const ServerAddress& server);

// The memory in which the server keeps the last seconds (flight::Recording::open).
Result<os::Descriptor> ask_for_flight(os::Clock& clock, const ServerAddress& server);

// A text as it passes between processes, if it is longer than a message may be.
Result<os::SharedMemory> to_memory(const std::string& text);
// kEnvironment: it holds no such text.
Result<std::string> from_memory(const os::SharedMemory& memory);

}  // namespace ctn::runtime
