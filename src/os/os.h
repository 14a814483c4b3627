// The operating system as Catan needs it: one small interface. `os/linux` implements it on Linux; `os/fake` in virtual
// time, and as a wrapper that injects faults. Nobody above names a scheduling class: there are levels, and what was set
// is read back.
//
// Units: Nanos and TimePoint of the monotonic clock. Thread safety: every call may be made from any thread at any time.
// Cost: now(), wait(), wake() and thread_cpu_time() are on the hot path; they never allocate or lock.
#pragma once

#include <atomic>
#include <compare>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/time.h"

namespace ctn::os {

// Kernel thread and process numbers.
enum class ThreadId : std::int32_t {};
enum class ProcessId : std::int32_t {};

// Who pre-empts whom: each level pre-empts all before it. kOrdinary is the system's fair scheduling, the rest is
// real-time.
enum class Level { kOrdinary, kBackground, kActive, kUnscheduled, kDispatcher };
const char* to_string(Level level);

// Beyond these there are fixed priorities, a level a rank: for programs that are compared with, and give each part one
// priority for good. Not to be used beside the levels above. Precondition: 0 <= rank < kFixedLevels.
constexpr int kFixedLevels = 66;
constexpr Level fixed_level(int rank) { return static_cast<Level>(static_cast<int>(Level::kDispatcher) + 1 + rank); }

// A set of CPU numbers, ascending, without duplicates.
class CpuSet {
 public:
  CpuSet() = default;
  CpuSet(std::initializer_list<int> cpus) : CpuSet(std::vector<int>(cpus)) {}
  explicit CpuSet(std::vector<int> cpus);

  const std::vector<int>& cpus() const& { return cpus_; }
  std::vector<int> cpus() && { return std::move(cpus_); }  // a loop over a temporary's CPUs would dangle otherwise
  bool empty() const { return cpus_.empty(); }
  std::size_t size() const { return cpus_.size(); }
  bool contains(int cpu) const;
  friend bool operator==(const CpuSet&, const CpuSet&) = default;

 private:
  std::vector<int> cpus_;
};

// The CPUs that are in both.
CpuSet common(const CpuSet& some, const CpuSet& others);

// "0-3,5" both ways, as Linux writes lists of CPUs. Errors: kCaller.
Result<CpuSet> parse_cpu_list(const std::string& text);
std::string to_string(const CpuSet& cpus);

struct Cpu {
  int number = 0;
  bool online = true;
  int core = 0;  // CPUs with equal core and package are hardware threads of one core
  int package = 0;
  std::optional<long> max_khz;  // where the kernel reports it
  std::optional<int> capacity;  // relative speed as the kernel sees it, 1024 for the fastest
};

struct Topology {
  std::vector<Cpu> cpus;  // ascending by number
  CpuSet online() const;
};

// What the machine grants to real-time threads, as found, not assumed.
struct RealTimeFacts {
  bool permitted = false;   // this process may raise a thread to kDispatcher; tried, not guessed
  std::string why_not;      // where not permitted: what was refused, and how to get it
  double reserved = 0.0;    // fraction of each CPU that the kernel keeps for ordinary threads
  std::string reserved_by;  // "fair server", "throttling", "fair server (assumed default)", "nothing"
};

// Facts for the record of a run; empty where unknown.
struct HostFacts {
  std::string utc;  // the wall clock when asked, ISO 8601 to the second; for readers only, nothing is computed from it
  std::string kernel;
  std::string cpu_model;
  std::string governor;
  std::string clock_source;
  int cpu_count = 0;
  Nanos steal{0};  // CPU time that a hypervisor took from this machine since boot, all CPUs
};

// What decides how fast CPUs run, as the kernel reports it; empty where it does not. For telling when it changes.
struct PowerState {
  struct Cpu {
    int number = 0;
    std::optional<long> limit_khz;  // no faster than this, for now
    std::string governor;
    friend bool operator==(const Cpu&, const Cpu&) = default;
  };
  std::optional<bool> on_mains;  // false: on battery
  std::vector<Cpu> cpus;         // ascending by number
  friend bool operator==(const PowerState&, const PowerState&) = default;
};

// A thread's scheduling as it was before Catan touched it. Only the implementation that made it can read it.
struct SavedScheduling {
  int policy = 0;
  int priority = 0;
  int nice = 0;
  bool reset_on_fork = false;
  CpuSet affinity;
  friend bool operator==(const SavedScheduling&, const SavedScheduling&) = default;
};

enum class WaitResult { kChanged, kTimedOut };

// A thread that ends before its handle does: the destructor joins.
class Thread {
 public:
  virtual ~Thread() = default;
  virtual void join() = 0;
};

// While it lives, idle CPUs stay ready for work. The kernel ends it with the process, however that ends.
class ReadyCpus {
 public:
  virtual ~ReadyCpus() = default;
};

// Gives threads of other processes their scheduling back if this process ends without doing so itself, however it ends:
// a second process, the guardian, outlives it for as long as that takes. What is watched it never touches before.
//
// Start it early: what this process has in memory by then the guardian keeps, too. It cannot help where it is killed
// together with this process. Thread safety: every call from any thread.
class Guard {
 public:
  // Ends the guardian, which gives back what has not been forgotten.
  virtual ~Guard() = default;

  // From now on the thread would get back `before`; of several calls the last counts. False, and then it would not:
  // the thread is gone, too many are watched (1024), or no guardian can be had.
  virtual bool watch(ThreadId thread, const SavedScheduling& before) = 0;
  // For a thread that got its scheduling back, or ended. Nothing happens where it is not watched.
  virtual void forget(ThreadId thread) = 0;

  // Where somebody ended the guardian, starts another in its place, which watches what it did. Cheap enough to be
  // called every second; watch() calls it, too. kEnvironment: none can be started; the next call tries again.
  virtual Status tend() = 0;
  // How often that was needed: what a user should be told when it grows.
  virtual int replaced() const = 0;
};

class Os {
 public:
  virtual ~Os() = default;

  virtual TimePoint now() = 0;
  // CPU time the calling thread has used; of another thread (kEnvironment when it is gone).
  virtual Nanos thread_cpu_time() = 0;
  virtual Result<Nanos> thread_cpu_time(ThreadId thread) = 0;

  // Blocks until the word is no longer `expected`, or the deadline (kNever: none) has passed. Returns at once if it
  // differs already. Spurious wake-ups are absorbed. The word may lie in memory shared between processes.
  virtual WaitResult wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) = 0;
  // Wakes all threads that wait on the word. The caller changed it before.
  virtual void wake(const std::atomic<std::uint32_t>& word) = 0;
  virtual void sleep_until(TimePoint deadline) = 0;

  virtual ProcessId current_process() = 0;
  virtual ThreadId current_thread() = 0;
  // Live threads of a process, ascending. kEnvironment when it is gone.
  virtual Result<std::vector<ThreadId>> threads(ProcessId process) = 0;
  // A new thread at the ordinary level, under a name of at most 15 characters (longer ones are cut).
  virtual std::unique_ptr<Thread> spawn(const std::string& name, std::function<void()> body) = 0;

  // Sets, reads back, and fails (kEnvironment) unless what was asked is what is. What the thread creates later does not
  // inherit a real-time level.
  virtual Status set_level(ThreadId thread, Level level) = 0;
  // The same for a dispatcher, which has no time to look and nobody to tell: one system call, no answer. For a thread
  // whose level was set with set_level() before; what was refused then is refused now.
  virtual void shift_level(ThreadId thread, Level level) = 0;
  virtual Result<Level> level(ThreadId thread) = 0;
  virtual Status set_affinity(ThreadId thread, const CpuSet& cpus) = 0;
  virtual Result<CpuSet> affinity(ThreadId thread) = 0;
  virtual Result<SavedScheduling> save_scheduling(ThreadId thread) = 0;
  virtual Status restore_scheduling(ThreadId thread, const SavedScheduling& saved) = 0;

  virtual Result<Topology> topology() = 0;
  // Cheap enough to be asked several times a second.
  virtual Result<CpuSet> online_cpus() = 0;
  virtual RealTimeFacts real_time_facts() = 0;
  virtual HostFacts host_facts() = 0;

  // The CPU that the calling thread is on; -1 where it cannot be told. On the hot path.
  virtual int current_cpu() = 0;
  // Of these CPUs. Cheap enough to be asked once a second.
  virtual PowerState power_state(const CpuSet& cpus) = 0;
  // CPU time that a hypervisor took from each CPU since boot; those that are not told are left out.
  virtual std::map<int, Nanos> stolen_time() = 0;

  // In a virtual machine, an idle CPU is given to others on the host, and comes back late and with cold caches: keeps
  // that from happening. Null where there is nothing to keep: on hardware of its own, idle CPUs save energy as the
  // system's settings say. kEnvironment where it is refused.
  virtual Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready() = 0;

  // kEnvironment where the system has no process left, or forbids what a guardian needs. Ended before this object.
  virtual Result<std::unique_ptr<Guard>> start_guard() = 0;
};

}  // namespace ctn::os
