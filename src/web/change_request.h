// Reads what a client asks to change: as JSON, the object of a `change` in runtime/protocol.h without its version.
//
//   {"cpus": [0, 1], "weights": [["scan -> LM", 0.5]], "maxes": [["0", 60.0]], "min_rates": [["GL", null]]}
//
// And what-if questions (what_if.h), which have the same keys and `"costs": {"LM": "x2"}, "cores": 2`.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "catan/changes.h"
#include "web/what_if.h"

namespace ctn::web {

// kCaller: the text is no such object.
Result<Changes> parse_change(std::string_view body);
Result<WhatIf> parse_what_if(std::string_view body);

// {"error": "...", "hint": "..."}: the answer to every request that is refused.
std::string error_json(std::string_view what, std::string_view hint);
std::string error_json(const Error& error);

}  // namespace ctn::web
