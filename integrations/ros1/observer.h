// What libcatan_ros1.so does where a program is observed for `catan ros bind`: callbacks are the program's own and are
// called as without Catan; what each does is written to a file (common/observation.h).
//
// The CPU time of a run is that of its thread, what it takes to make the message from its bytes included. What it
// publishes is what its thread publishes before it returns.
//
// Thread safety: as roscpp's own functions.
#pragma once

#include <string>

#include "ros1/hooks.h"

namespace catan_ros {

// Files are made in `folder`.
const Hooks* observing_hooks(const std::string& folder);

}  // namespace catan_ros
