// The process that outlives a server and restores the scheduling of the threads that the server had changed. Inside
// os/linux only.
//
// It is forked from the server, which may have threads by then: so it allocates nothing, takes no lock, and makes
// system calls alone. It sleeps until the server has ended, which it learns in the first of three ways: the thread that
// forked it is gone (monitored_thread.h), which is soonest on a busy machine; the socket that only the server holds is
// closed; the kernel says that all of the process is gone (pidfd), even if a child of it has the socket, too. A server
// that leaves a core dump has ended when that is written.
//
// The threads of a server that is killed end in no order, and a call of one that sets a level may be carried out after
// the guardian was woken by the end of another. So it sets everything again every 5 ms, until all of the server is gone
// or ten seconds have passed.
//
// It survives what ends the server: it is in a session of its own, blocks all signals, and has no file open. It runs
// above all levels, for a fraction of a millisecond, because the threads that it has to lower may keep every CPU busy.
//
// The table: the server fills an entry and then publishes it, so wherever it is killed, the guardian, which reads only
// after that, finds an entry that is whole or none.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "os/linux/restore.h"

namespace ctn::os {

constexpr std::size_t kMaxWatched = 1024;

struct WatchedThread {
  std::atomic<std::uint32_t> published{0};
  SavedThread saved;
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
static_assert(std::is_trivially_copyable_v<SavedThread>);

struct GuardianTable {
  std::array<WatchedThread, kMaxWatched> threads;
};

// What the child of the fork does, until its end. `monitor_socket`: readable when the server has closed the other end;
// one byte is written to it when the guardian is ready. `server`: pidfd, or negative. All signals are blocked already.
[[noreturn]] void run_guardian(const GuardianTable& table, const char* procfs, int monitor_socket, int server);

}  // namespace ctn::os
