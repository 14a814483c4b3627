// Why responses of a chain were late, as text for a terminal.
//
// Thread safety: pure functions.
#pragma once

#include <string>

#include "base/time.h"
#include "graph/app.h"
#include "why/why.h"

namespace ctn::tool {

// Instants are since `started`.
std::string why_text(const why::Analysis& analysis, const graph::App& app, TimePoint started);

}  // namespace ctn::tool
