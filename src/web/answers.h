// What answers have in common: headers, the text of refusals, events of a stream.
//
// Thread safety: pure functions.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "web/request_head.h"

namespace ctn::web {

constexpr const char* kJson = "application/json";

// The page loads nothing from elsewhere, browsers keep nothing, and no page of another site may show or read it.
inline constexpr std::array<std::pair<const char*, const char*>, 6> kSafety{
    {{"Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
     {"X-Content-Type-Options", "nosniff"},
     {"X-Frame-Options", "DENY"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Cache-Control", "no-store"}}};

// The whole answer to a request that is refused; the connection ends after it.
std::string answer_of(const Refusal& refusal);

// A server-sent event, in which each line of the text is a field of its own.
std::string event_of(std::string_view name, std::string_view text);

}  // namespace ctn::web
