// How a program reaches its server: over a socket (client_link.h), and in tests in virtual time.
//
// Thread safety: wait() from one thread; the rest from any.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "base/result.h"
#include "base/time.h"
#include "os/linux/shared_memory.h"
#include "os/threads.h"
#include "runtime/protocol.h"

namespace ctn::runtime {

// What the caller has to do while it waits for an answer; says when it is to be called again. None: stop waiting.
using Meanwhile = std::function<std::optional<TimePoint>()>;

// To send requests. One thread has it at a time, and keeps it while it waits for answers.
class Conversation {
 public:
  Conversation() = default;
  virtual ~Conversation() = default;
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  // A new connection in place of the one before; says hello for the thread that serves it. Returns the region's memory.
  // kEnvironment: no server is there, or it does not answer. kCaller: it refuses.
  virtual Result<os::SharedMemory> dial(os::ThreadId service, const Meanwhile& meanwhile) = 0;
  // Asks and waits for the answer, for two seconds at most. kEnvironment: there is no connection, or it was lost, or
  // the answer did not come, and then there is none any more.
  virtual Status call(const Request& request, const Meanwhile& meanwhile) = 0;
  Status call(const Request& request) { return call(request, {}); }
};

class ServerLink {
 public:
  ServerLink() = default;
  virtual ~ServerLink() = default;
  ServerLink(const ServerLink&) = delete;
  ServerLink& operator=(const ServerLink&) = delete;

  // Waits until no other thread has one.
  virtual std::unique_ptr<Conversation> converse() = 0;
  // Blocks until the server is gone, the deadline has passed, or another thread wakes it. True: it is gone, or did not
  // answer, and there is no connection any more. Not before the first dial().
  virtual bool wait(TimePoint deadline) = 0;
  // Ends whatever is being waited for.
  virtual void hang_up() = 0;
};

}  // namespace ctn::runtime
