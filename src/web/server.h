// A small HTTP server for one page and its data, for clients that may be many, slow or hostile: docs/http.md lists its
// paths. cpp-httplib routes requests and writes answers; the requests that it reads have been checked and written anew
// (request_head.h). Every wait for a client has a deadline.
//
//   16 clients are served at once, streams of events included; any more get 503, and their connection ends.
//   The head of a request must have come 5 s after its first byte, a request 5 s after the one before, and each part
//   of an answer must be taken within 5 s.
//   A connection carries at most 100 requests, and a stream of events lasts at most an hour; browsers connect again.
//
// Errors are JSON: {"error": "...", "hint": "..."}.
//
// Thread safety: stop() from any thread, everything else from one. Threads: the one that calls run() lets clients in,
// and has those for which there is no room (turned_away.h); one for each client that is served at once (seats.h) reads
// its requests (conversation.h) and answers them (routes.h). stop_sign.h tells them all that the server stops.
#pragma once

#include <functional>
#include <memory>

#include "base/result.h"
#include "os/linux/tcp.h"
#include "os/os.h"
#include "web/access.h"
#include "web/limits.h"
#include "web/source.h"

namespace ctn::web {

class Server {
 public:
  // Listens from now on; clients wait until run() is called. `token`: what a request for control must send; none:
  // nothing can be changed. `os` and `source` outlive the server. Errors: as TcpListener::open().
  static Result<std::unique_ptr<Server>> open(os::Os& os, Source& source, const os::TcpAddress& address,
                                              std::optional<std::string> token, const Limits& limits = {});
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // With the port that the system chose.
  const os::TcpAddress& address() const;

  // run() calls `ready` whenever the descriptor is readable. The descriptor must stay open until run() has returned.
  Status watch(const os::Descriptor& descriptor, std::function<void()> ready);
  // Serves until stop(); then all clients are cut off.
  void run();
  void stop();

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn::web
