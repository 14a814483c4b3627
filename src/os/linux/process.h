// Facts about other processes and their threads, for a server that is asked to schedule them.
//
// A number alone says little: when a thread ends, its number may be given to another. Its start time tells the two
// apart. To act on a thread of another process: note its start time, act, and look whether the start time is still the
// same.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "os/linux/descriptor.h"
#include "os/linux/files.h"
#include "os/os.h"

namespace ctn::os {

// When a thread began, in jiffies since the system's start; nothing when it is gone.
std::optional<std::uint64_t> start_time(ThreadId thread, const LinuxRoots& roots = {});

// The same for where nothing may be allocated and no lock taken, as in the child of a fork.
std::optional<std::uint64_t> read_start_time(const char* procfs, ThreadId thread);
// The start time in the text of /proc/TID/stat. The thread's name in it may hold anything.
std::optional<std::uint64_t> parse_start_time(std::string_view stat);

// Whether a process has ended, or is about to: one that ends closes its descriptors before it counts as ended.
bool is_ending(ProcessId process, const LinuxRoots& roots = {});

// The user that this process acts as.
std::uint32_t current_user();

// Becomes readable once the process has ended, whichever other process has its sockets (pidfd). None when it is gone
// already, then errno is ESRCH, or where the system gives none.
Descriptor watch_process(ProcessId process);

}  // namespace ctn::os
