// An analysis as JSON, for programs.
#pragma once

#include <string>

#include "base/time.h"
#include "graph/app.h"
#include "why/why.h"

namespace ctn::why {

// One document, indented by one space, with a newline at its end. Units are in the names of the keys; instants are
// since `started`. Schema: docs/report-schema.md.
std::string to_json(const Analysis& analysis, const graph::App& app, TimePoint started);

}  // namespace ctn::why
