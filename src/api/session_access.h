// What a session does for the project's own tools and for no other program.
#pragma once

#include "catan/result.h"
#include "catan/session.h"
#include "graph/app.h"

namespace ctn {

class SessionAccess {
 public:
  // Session::open() for a caller that has read the app file already, and needs the app as it was then.
  static Result<Session> open(graph::App app, const SessionOptions& options);
};

}  // namespace ctn
