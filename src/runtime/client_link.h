// A process's connection to its server (server.h), of which there may be several one after the other.
//
// wait() and hang_up() never wait for a conversation: hang_up() ends whatever is being waited for. If an answer does
// not come in time, the connection is ended, since the answer could be taken for that to the next request.
//
// Thread safety: wait() from one thread; the rest from any.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/guarded.h"
#include "base/result.h"
#include "os/clock.h"
#include "os/linux/connection.h"
#include "os/linux/poller.h"
#include "os/linux/shared_memory.h"
#include "os/threads.h"
#include "runtime/protocol.h"
#include "runtime/server_link.h"

namespace ctn::runtime {

class ClientLink : public ServerLink {
  class Line;

 public:
  // `clock` outlives it. `sockets`: paths to try, in this order.
  ClientLink(os::Clock& clock, std::vector<std::string> sockets) : clock_(clock), sockets_(std::move(sockets)) {}
  ~ClientLink() override;

  std::unique_ptr<Conversation> converse() override;
  bool wait(TimePoint deadline) override;
  void wake();
  void hang_up() override;

 private:
  class LockedConversation;

  Result<std::shared_ptr<Line>> connect() const;
  Result<os::SharedMemory> dial(os::ThreadId service, const Meanwhile& meanwhile);
  Status call(const Request& request, const Meanwhile& meanwhile);
  Result<os::Message> ask(const std::shared_ptr<Line>& line, const Request& request, const Meanwhile& meanwhile);
  void drop(const std::shared_ptr<Line>& line);

  os::Clock& clock_;
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
