// Who may ask for what.
//
// A page of another site, open in a browser on this machine, can send requests here, and can have its name resolve to
// this machine (DNS rebinding), so that the browser takes both for one site. Hence: where the server listens on a
// loopback address, only requests that name a loopback host are answered. Control needs a token that only the user
// knows, is refused to pages of other sites (Origin), and is off unless it was asked for. So is planning what is not
// done
// (/whatif) refused to them: it takes CPU time.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "web/request_head.h"

namespace ctn::web {

struct AccessRules {
  bool loopback_only = true;           // listens where only this machine reaches it
  std::optional<std::string> token{};  // that control needs; none: there is no control
};

// Nothing: the request may go on.
std::optional<Refusal> check_access(const RequestHead& head, const AccessRules& rules);

// The host of "HOST", "HOST:PORT" or "[HOST]:PORT"; empty: it is none of these.
std::string_view host_of(std::string_view authority);

// Compares all bytes, however early they differ, so that no time tells how much of a guess is right.
bool same_secret(std::string_view a, std::string_view b);

// What a token may be: 16 to 256 characters, printable and without blanks. kCaller: it is not.
Result<std::string> token_from(std::string_view text);

}  // namespace ctn::web
