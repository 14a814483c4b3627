// Libraries of the ports to frameworks: those that are loaded into programs, with how programs are told of them, and
// those that the command loads. They lie beside the command, where both are built, or installed.
//
// Thread safety: pure functions of the environment and the file system. Errors: kEnvironment: this Catan was built
// without that library.
#pragma once

#include <string>

#include "base/result.h"

namespace ctn::tool {

// "LD_PRELOAD=...", in front of what is preloaded already.
Result<std::string> ros_preload_entry();
// Of the library that knows the threads which nodes make.
Result<std::string> threads_preload_entry();

// The path of a library of the port to ROS 1.
Result<std::string> find_ros_library(const char* name);

}  // namespace ctn::tool
