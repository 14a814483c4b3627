// What was measured, for Prometheus: its text format, version 0.0.4. docs/http.md lists the metrics.
//
// By Prometheus's conventions times are in seconds, and what only grows ends in `_total`. What is not known is left
// out.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <string_view>

namespace ctn::web {

// `snapshot`, `live`: as Source has them. What is no such document, an empty text say, is left out; where neither is
// one, there is only `catan_up 0`.
std::string metrics_text(std::string_view snapshot, std::string_view live);

}  // namespace ctn::web
