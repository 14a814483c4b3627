// Libraries that are loaded into programs for Catan, and how programs are told of them.
//
// Thread safety: pure functions of the environment and the file system.
#pragma once

#include <string>

#include "base/result.h"

namespace ctn::tool {

// "LD_PRELOAD=...", in front of what is preloaded already. kEnvironment: this Catan was built without it.
Result<std::string> ros_preload_entry();
// Of the library that knows the threads which nodes make.
Result<std::string> threads_preload_entry();

}  // namespace ctn::tool
