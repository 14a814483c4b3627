// The library that is loaded into ROS programs for Catan, and how they are told of it: what `catan ros run` and
// `catan ros bind` share.
//
// Thread safety: pure functions of the environment and the file system.
#pragma once

#include <string>

#include "base/result.h"

namespace ctn::tool {

// "LD_PRELOAD=...", in front of what is preloaded already. kEnvironment: this Catan was built without ROS 1.
Result<std::string> ros_preload_entry();

}  // namespace ctn::tool
