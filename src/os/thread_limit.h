// Where the system has no thread left, Threads::spawn() throws, since few callers can do anything about it. Those who
// start something that a user asked for turn that into an error, and undo what they have begun.
#pragma once

#include <string>
#include <system_error>
#include <utility>

#include "base/result.h"

namespace ctn::os {

// What `make` returns, a Status, or that there was no thread left for it. kEnvironment.
template <class Make>
Status within_thread_limit(Make&& make) {
  try {
    return std::forward<Make>(make)();
  } catch (const std::system_error& failed) {
    if (failed.code() != std::errc::resource_unavailable_try_again) throw;
    return Error::environment(std::string("no thread can be made: ") + failed.what(),
                              "raise the limit of threads (`ulimit -u`, or the control group's pids.max)");
  }
}

}  // namespace ctn::os
