// For a process that works for others beside what is scheduled (`catan http`): how it keeps out of the way, and ends
// with the process that started it.
//
// Thread safety: of the whole process; call them before it has other threads. yield_to_all() is the calling thread's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.h"
#include "os/os.h"

namespace ctn::os {

// Ordinary threads of others come first: nice 5, also for threads that are made from then on.
void yield_to_others();

// All other threads of the process come before the calling one: nice 10. It stays so.
void yield_to_all();

// Whatever its clients do, it takes no more than this.
void limit_resources(std::uint64_t open_files, std::uint64_t memory_bytes);

// It is sent SIGTERM when the thread ends that started it. False: `parent` has ended already, or did not start it.
bool end_with(ProcessId parent);

// So many random bytes, as hexadecimal digits. kEnvironment: the system has none.
Result<std::string> random_digits(std::size_t bytes);

}  // namespace ctn::os
