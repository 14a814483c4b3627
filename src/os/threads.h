// Threads and processes: which there are, making them, what they use, and how they wait for each other.
//
// Units: Nanos and TimePoint of the monotonic clock. Thread safety: any thread at any time. Cost: wait(), wake(),
// current_cpu(), thread_cpu_time(), CpuClock::now(), times_blocked() and the calling thread's ready_time() are on the
// hot path; they never lock, nor allocate but for the first ready_time() of a thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/time.h"

namespace ctn::os {

// Kernel thread and process numbers.
enum class ThreadId : std::int32_t {};
enum class ProcessId : std::int32_t {};

enum class WaitResult { kChanged, kTimedOut };

// A thread that ends before its handle does: the destructor joins.
class Thread {
 public:
  virtual ~Thread() = default;
  virtual void join() = 0;
};

// The CPU time of one thread, for callers that ask often: the thread is looked up once.
class CpuClock {
 public:
  virtual ~CpuClock() = default;
  // None: the thread is gone.
  virtual std::optional<Nanos> now() = 0;
};

class Threads {
 public:
  virtual ~Threads() = default;

  virtual ProcessId current_process() = 0;
  virtual ThreadId current_thread() = 0;
  // The one that a process began with, whether or not it has ended. Tools that are given a process's number mean it.
  virtual ThreadId main_thread(ProcessId process) = 0;
  // The CPU that the calling thread is on; -1 where it cannot be told.
  virtual int current_cpu() = 0;
  // Live threads of a process, ascending. kEnvironment when it is gone.
  virtual Result<std::vector<ThreadId>> threads(ProcessId process) = 0;
  // A new thread at the ordinary level, under a name of at most 15 characters (longer ones are cut). Throws
  // std::system_error where the system has no thread left (thread_limit.h).
  virtual std::unique_ptr<Thread> spawn(const std::string& name, std::function<void()> body) = 0;
  // As its program has named it; empty when it is gone, or has no name.
  virtual std::string thread_name(ThreadId thread) = 0;

  // CPU time the calling thread has used; of another thread (kEnvironment when it is gone).
  virtual Nanos thread_cpu_time() = 0;
  virtual Result<Nanos> thread_cpu_time(ThreadId thread) = 0;
  // kEnvironment when it is gone.
  virtual Result<std::unique_ptr<CpuClock>> cpu_clock(ThreadId thread) = 0;

  // --- What a thread did when it did not run ---
  // How often the calling thread has given its CPU away so far, to wait for something. What was taken from it does not
  // count.
  virtual std::uint64_t times_blocked() = 0;
  // How long the calling thread was ready to run so far while others had the CPU. None: the system does not tell.
  virtual std::optional<Nanos> ready_time() = 0;
  // The same of another thread, where a time in which it is still ready may be left out. None: it is gone, or the
  // system does not tell.
  virtual std::optional<Nanos> ready_time(ThreadId thread) = 0;

  // Blocks until the word is no longer `expected`, or the deadline (kNever: none) has passed. Returns at once if it
  // differs already. Spurious wake-ups are absorbed. The word may lie in memory shared between processes.
  virtual WaitResult wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) = 0;
  // The same, without a deadline, and it also returns where the word was woken and has not changed, or for no reason:
  // for a thread that waits for something else, too, of which it is told by a wake.
  virtual void wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) = 0;
  // Wakes all threads that wait on the word. The caller changed it before, but for those in wait_for_wake().
  virtual void wake(const std::atomic<std::uint32_t>& word) = 0;
};

}  // namespace ctn::os
