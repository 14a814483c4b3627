// What a session does for the project's own tools and for no other program.
#pragma once

#include "catan/result.h"
#include "catan/session.h"
#include "graph/app.h"
#include "os/linux/descriptor.h"

namespace ctn {

class SessionAccess {
 public:
  // Session::open() for a caller that has read the app file already, and needs the app as it was then.
  static Result<Session> open(graph::App app, const SessionOptions& options);
  // The memory in which it keeps the last seconds (flight::Recording::open). Errors: it was not started; none is kept.
  static Result<os::Descriptor> flight(const Session& session);
};

}  // namespace ctn
