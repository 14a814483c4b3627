// A process's connection to its server (server.h), of which there may be several one after the other.
//
// To send requests, a thread takes the Conversation, which one thread has at a time, and keeps it while it waits for
// answers. wait() and hang_up() never wait for that: hang_up() ends whatever is being waited for. If an answer does not
// come in time, the connection is ended, since the answer could be taken for that to the next request.
//
// Thread safety: wait() from one thread; the rest from any.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/guarded.h"
#include "base/result.h"
#include "os/linux/connection.h"
#include "os/linux/poller.h"
#include "os/linux/shared_memory.h"
#include "os/os.h"
#include "runtime/protocol.h"

namespace ctn::runtime {

class ClientLink {
  class Line;

 public:
  // `os` outlives it. `sockets`: paths to try, in this order.
  ClientLink(os::Os& os, std::vector<std::string> sockets) : os_(os), sockets_(std::move(sockets)) {}
  ~ClientLink();

  // What the caller has to do while it waits for an answer; says when it is to be called again. None: stop waiting.
  using Meanwhile = std::function<std::optional<TimePoint>()>;

  class Conversation {
   public:
    explicit Conversation(ClientLink& link) : link_(link), lock_(link.conversation_) {}

    // A new connection in place of the one before; says hello for the thread that serves it. Returns the region's
    // memory. kEnvironment: nobody is there, or it does not answer. kCaller: it refuses.
    Result<os::SharedMemory> dial(os::ThreadId service, const Meanwhile& meanwhile = {}) const;
    // Asks and waits for the answer, for two seconds at most. kEnvironment: there is no connection, or it was lost, or
    // the answer did not come, and then there is none any more.
    Status call(const Request& request, const Meanwhile& meanwhile = {}) const;

   private:
    ClientLink& link_;
    std::unique_lock<std::mutex> lock_;
  };
  Conversation converse() { return Conversation(*this); }

  // Blocks until the server is gone, the deadline has passed, or wake() is called. True: it is gone, or did not answer,
  // and there is no connection any more. Not before the first dial().
  Result<bool> wait(TimePoint deadline);
  void wake();
  void hang_up();

 private:
  Result<std::shared_ptr<Line>> connect() const;
  Result<os::SharedMemory> dial(os::ThreadId service, const Meanwhile& meanwhile);
  Result<os::Message> ask(const std::shared_ptr<Line>& line, const Request& request, const Meanwhile& meanwhile);
  void drop(const std::shared_ptr<Line>& line);

  os::Os& os_;
  std::vector<std::string> sockets_;
  std::mutex conversation_;
  std::unique_ptr<os::Poller> watcher_;  // from the first dial() on
  struct Current {
    std::shared_ptr<Line> line;
    bool unanswered = false;  // the line was dropped for want of an answer, which wait() is to tell
  };
  Guarded<Current> current_;
};

}  // namespace ctn::runtime
