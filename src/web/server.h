// A small HTTP server for one page and its data, for clients that may be many, slow or hostile: docs/http.md lists its
// paths. cpp-httplib routes and writes; what it reads was checked and written anew before (request_head.h), and every
// wait for a client has a deadline.
//
//   16 clients are served at once, streams of events among them; another is told so (503) and let go.
//   A request has 5 s to come once it began, a connection without one 5 s; so has each part of an answer to be taken.
//   A connection carries at most 100 requests, a stream of events lasts at most an hour; browsers come again.
//
// Errors are JSON: {"error": "...", "hint": "..."}.
//
// Thread safety: stop() from any thread, everything else from one. Threads: one a client that is served, which is made
// when it is first needed and kept.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

#include "base/result.h"
#include "base/time.h"
#include "os/linux/tcp.h"
#include "os/os.h"
#include "web/access.h"
#include "web/source.h"

namespace ctn::web {

struct Limits {
  std::size_t clients = 16;
  std::size_t requests = 100;  // on one connection
  Nanos idle = std::chrono::seconds{5};
  Nanos request = std::chrono::seconds{5};  // its head; its body has as long again
  Nanos answer = std::chrono::seconds{5};   // each part of it
  Nanos stream = std::chrono::hours{1};
  Nanos step = std::chrono::milliseconds{500};  // between two events; documents are kept as long
};

class Server {
 public:
  // Listens from then on; clients wait for run(). `token`: that control needs; none: nothing can be changed. Outlived
  // by `os` and `source`. Errors: as TcpListener::open().
  static Result<std::unique_ptr<Server>> open(os::Os& os, Source& source, const os::TcpAddress& address,
                                              std::optional<std::string> token, const Limits& limits = {});
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // With the port that the system chose.
  const os::TcpAddress& address() const;

  // Has `ready` called by run() whenever the descriptor is readable. It stays open until run() has returned.
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
