// From what was written to an `App`: resolves names, completes defaults, checks every invariant of app.h.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "graph/spec.h"

namespace ctn::graph {

// All that is wrong is reported at once, in the order it was written; nothing is half-built. Errors are of kind
// kCaller.
Result<App> build_app(const AppSpec& spec);

}  // namespace ctn::graph
