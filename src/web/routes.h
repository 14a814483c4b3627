// What is answered to which request: the page, documents, streams of events, changes, what-if questions. A request that
// comes here is allowed (access.h), and has been written anew (request_head.h).
//
// Thread safety: answer() from any thread; requests of several clients are answered at once. The source is asked for
// one change at a time, for one what-if question, and once for each document.
#pragma once

#include <memory>

#include "os/os.h"
#include "web/limits.h"
#include "web/source.h"
#include "web/stop_sign.h"

namespace httplib {
class Stream;
}

namespace ctn::web {

class Routes {
 public:
  // `listening`: number of the server's socket. All references outlive it.
  Routes(os::Os& os, Source& source, const Limits& limits, const StopSign& stop, bool may_control, int listening);
  ~Routes();
  Routes(const Routes&) = delete;
  Routes& operator=(const Routes&) = delete;

  // Reads one request from the stream, and writes the answer to it. `last`: of its connection. False: the connection
  // must be closed. Streams of events end with the sign to stop.
  bool answer(httplib::Stream& stream, bool last);
  // No stream of events goes on.
  void end();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn::web
