// What was measured, in the text format of Prometheus, version 0.0.4. docs/http.md lists the metrics.
//
// By Prometheus's conventions times are in seconds, and the names of counters end in `_total`. What is not known
// is left out.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <string_view>

namespace ctn::web {

// `snapshot`, `live`: the documents of Source. A text that is no such document, an empty one for example, contributes
// nothing; where neither is one, all there is is `catan_up 0`.
std::string metrics_text(std::string_view snapshot, std::string_view live);

}  // namespace ctn::web
