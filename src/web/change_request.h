// What a client asks to change: the object of a `change` in runtime/protocol.h, without its version, as JSON.
//
//   {"cpus": [0, 1], "weights": [["scan -> LM", 0.5]], "maxes": [["0", 60.0]], "min_rates": [["GL", null]]}
//
// And what it asks of what is not done (what_if.h): the same, and with `"costs": {"LM": "x2"}, "cores": 2`.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "catan/changes.h"
#include "web/what_if.h"

namespace ctn::web {

// kCaller: it is not understood.
Result<Changes> parse_change(std::string_view body);
Result<WhatIf> parse_what_if(std::string_view body);

// {"error": "...", "hint": "..."}, as all that is refused is answered.
std::string error_json(std::string_view what, std::string_view hint);
std::string error_json(const Error& error);

}  // namespace ctn::web
