// One client, from its first request to the end of its connection: reads what it asks, refuses what is not allowed or
// does not come in time, and has the rest answered (routes.h).
//
// Thread safety: none; it lives in the thread of the client's seat (seats.h). What it refers to is shared by all.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "os/clock.h"
#include "os/linux/tcp.h"
#include "web/access.h"
#include "web/limits.h"
#include "web/request_head.h"
#include "web/routes.h"
#include "web/stop_sign.h"

namespace ctn::web {

class Conversation {
 public:
  // All references outlive it.
  Conversation(os::Clock& clock, const Limits& limits, const AccessRules& rules, const StopSign& stop, Routes& routes,
               const os::TcpConnection& client)
      : clock_(clock), limits_(limits), rules_(rules), stop_(stop), routes_(routes), client_(client) {}

  // Until the client has gone, is too slow, or has had all requests that it may, or the server stops.
  void hold();

 private:
  // Nothing: the client has gone, or sent nothing in time.
  std::optional<std::variant<RequestHead, Refusal>> receive_head();
  void refuse(const Refusal& refusal);

  os::Clock& clock_;
  const Limits& limits_;
  const AccessRules& rules_;
  const StopSign& stop_;
  Routes& routes_;
  const os::TcpConnection& client_;
  std::string received_;  // and not yet used
};

}  // namespace ctn::web
