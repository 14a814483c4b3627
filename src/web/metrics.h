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

// `snapshot`: as Source::snapshot() has it. What is no such document gives only `catan_up 0`.
std::string metrics_text(std::string_view snapshot);
// The scheduler does not answer.
std::string metrics_of_none();

}  // namespace ctn::web
