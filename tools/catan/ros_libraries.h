// The libraries of the port to ROS 1, and how programs into which one is loaded are told of it: what the commands of
// `catan ros` share.
//
// Thread safety: pure functions of the environment and the file system.
#pragma once

#include <string>

#include "base/result.h"

namespace ctn::tool {

// The path of a library of the port, by its name. kEnvironment: this Catan was built without ROS 1.
Result<std::string> find_ros_library(const char* name);

// "LD_PRELOAD=...", in front of what is preloaded already. Errors: as above.
Result<std::string> ros_preload_entry();

}  // namespace ctn::tool
