// A process's connection to its server (server.h), of which there may be several one after the other.
//
// Thread safety: dial(), call() and what is below them from any thread, one at a time (they lock).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "os/linux/connection.h"
#include "os/linux/poller.h"
#include "os/linux/shared_memory.h"
#include "os/os.h"
#include "runtime/protocol.h"

namespace ctn::runtime {

class ClientLink {
 public:
  // `os` outlives it. `sockets`: paths to try, in this order.
  ClientLink(os::Os& os, std::vector<std::string> sockets) : os_(os), sockets_(std::move(sockets)) {}

  // What the caller has to do while it waits for an answer; says when it is to be called again.
  using Meanwhile = std::function<TimePoint()>;

  // A new connection in place of the one before; says hello for the thread that serves it. Returns the region's memory.
  // kEnvironment: nobody is there, or it refuses.
  Result<os::SharedMemory> dial(os::ThreadId service, const Meanwhile& meanwhile = {});
  // Asks and waits for the answer, for two seconds at most. kEnvironment: there is no connection, or it was lost.
  Status call(const Request& request);

  // Blocks until the server is gone, the deadline has passed, or wake() is called. True: it is gone, and there is no
  // connection any more. From one thread.
  Result<bool> wait(TimePoint deadline);
  void wake();
  void hang_up();
  const std::string& path() const { return path_; }

 private:
  Status ask(const Request& request, os::Message& answer, const Meanwhile& meanwhile = {});
  bool server_is_gone();

  os::Os& os_;
  std::vector<std::string> sockets_;
  std::string path_;  // of the newest connection
  std::unique_ptr<os::Poller> watcher_;
  std::mutex mutex_;  // guards what follows
  std::optional<os::Connection> connection_;
  std::unique_ptr<os::Poller> answers_;
};

}  // namespace ctn::runtime
