// The process that outlives a server and gives the threads it had scheduled their scheduling back. Inside os/linux
// only.
//
// It is forked from the server, which may have threads by then: so it allocates nothing, takes no lock, and makes
// system calls alone. It sleeps until the server has ended, which it learns in the first of three ways: the thread that
// forked it is gone (sentinel.h), which is soonest on a busy machine; the socket that only the server holds is closed;
// the kernel says that all of the process is gone (pidfd), even if a child of it has the socket, too. A server that
// leaves a core dump has ended when that is written.
//
// The threads of a server that is killed end in no order, and a call of one that sets a level may be carried out after
// the guardian was woken by the end of another. So it sets everything again every 5 ms, until all of the server is gone
// or ten seconds have passed.
//
// It keeps what the server lets go of: it is in a session of its own, blocks all signals, and has no file open. It runs
// above all levels, because the threads that it is to tame may keep every CPU busy, for the fraction of a millisecond
// that it takes.
//
// The table: the server fills an entry and then publishes it, so wherever it is killed, the guardian, which reads only
// after that, finds an entry that is whole or none.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace ctn::os {

constexpr std::size_t kMaxWatched = 1024;
constexpr std::size_t kMaxGuardedCpu = 1024;  // CPUs with larger numbers are not given back

struct WatchedThread {
  std::atomic<std::uint32_t> published{0};
  std::int32_t thread = 0;
  std::uint64_t started = 0;  // clock ticks since the system's start
  std::int32_t policy = 0;
  std::int32_t priority = 0;
  std::int32_t nice = 0;
  std::uint32_t reset_on_fork = 0;
  std::array<std::uint64_t, kMaxGuardedCpu / 64> cpus{};  // as the kernel has them, a bit a CPU
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

struct GuardTable {
  std::array<WatchedThread, kMaxWatched> threads;
};

// What the child of the fork does, until its end. `lifeline`: readable when the server lets go of the other end; one
// byte is written to it when the guardian is ready. `server`: pidfd, or negative. All
// signals are blocked already.
[[noreturn]] void stand_guard(const GuardTable& table, const char* procfs, int lifeline, int server);

}  // namespace ctn::os
