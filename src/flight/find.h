// Finds the flight recorders (recorder.h) of running processes, sessions and servers alike, through /proc. A user sees
// those of processes that may be traced: the own ones (of programs without file capabilities), root all.
//
// Thread safety: pure functions of the system's state.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "os/linux/descriptor.h"

namespace ctn::flight {

struct Found {
  std::int32_t process = 0;
  std::string app;  // its name
};

// By process; a process that has several is there several times.
std::vector<Found> find_all();

// The memory of the one whose app is called `app`, or whose process has that number; an empty name: of the only one.
// Errors: none, several (kCaller).
Result<os::Descriptor> find(const std::string& app_or_process);

}  // namespace ctn::flight
