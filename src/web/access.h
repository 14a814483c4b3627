// Which requests are allowed.
//
// A page of another site, open in a browser on this machine, can send requests here, and can make its name resolve to
// this machine (DNS rebinding), so that the browser takes both for one site. Therefore, where the server listens on a
// loopback address, it answers only requests that name a loopback host. Control is off unless it was asked for; it
// needs a token that only the user knows, and is refused to pages of other sites (Origin). Questions of what would be
// planned (/whatif) are refused to them, too, since they take CPU time.
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
  bool loopback_only = true;           // the server listens where only this machine reaches it
  std::optional<std::string> token{};  // what a request for control must send; none: control is off
};

// Nothing: the request is allowed.
std::optional<Refusal> check_access(const RequestHead& head, const AccessRules& rules);

// The host of "HOST", "HOST:PORT" or "[HOST]:PORT"; empty: the text is none of these.
std::string_view host_of(std::string_view authority);

// Compares all bytes, however early they differ, so that the time it takes does not tell how much of a guess is right.
bool same_secret(std::string_view a, std::string_view b);

// The token that the text is. kCaller: it is not 16 to 256 printable characters without blanks.
Result<std::string> token_from(std::string_view text);

}  // namespace ctn::web
