#include "os/linux/linux_os.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include "os/linux/descriptor.h"
#include "os/linux/facts.h"
#include "os/linux/guardian.h"
#include "os/linux/idle.h"
#include "os/linux/online_cpus.h"
#include "os/linux/power.h"
#include "os/linux/scheduling.h"
#include "os/linux/topology.h"
#include "os/thread_limit.h"

namespace ctn::os {
namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == 4 && std::atomic<std::uint32_t>::is_always_lock_free,
              "a futex is a 32-bit word in memory and nothing else");

// 0: not asked yet. Reset in the child of a fork, whose only thread has a new number.
thread_local pid_t cached_thread = 0;

// The calling thread's schedstat file, from the first time that it is asked for; after a fork another one.
thread_local Descriptor own_schedstat;

void forget_thread_on_fork() {
  static std::once_flag once;
  std::call_once(once, [] {
    ::pthread_atfork(nullptr, nullptr, [] {
      cached_thread = 0;
      own_schedstat.reset();
    });
  });
}

timespec to_timespec(TimePoint time) {
  const Nanos since_boot = std::max(time.time_since_epoch(), Nanos{0});
  timespec result{};
  result.tv_sec = static_cast<time_t>(since_boot.count() / 1'000'000'000);
  result.tv_nsec = static_cast<long>(since_boot.count() % 1'000'000'000);
  return result;
}

Nanos to_nanos(const timespec& time) { return Nanos{std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec}; }

// Waking never writes to the word; the kernel's interface only lacks the const.
long futex(const std::atomic<std::uint32_t>& word, int operation, std::uint32_t value, const timespec* deadline) {
  return ::syscall(SYS_futex, &word, operation, value, deadline, nullptr, FUTEX_BITSET_MATCH_ANY);
}

[[noreturn]] void die(const char* call, int error) {
  std::fprintf(stderr, "catan: %s failed with errno %d, which no correct call gets\n", call, error);
  std::abort();
}

// Larger numbers would encode other clocks. The kernel's own limit is lower (2^22).
constexpr int kMaxThreadNumber = (1 << 28) - 1;

// The kernel's number for the CPU clock of one thread: its complement, "per thread" and "as scheduled".
clockid_t cpu_clock_of(ThreadId thread) {
  const auto bits = ~static_cast<std::uint32_t>(thread) << 3U | 4U | 2U;
  return static_cast<clockid_t>(bits);
}

bool may_be_thread(ThreadId thread) {
  return static_cast<int>(thread) > 0 && static_cast<int>(thread) <= kMaxThreadNumber;
}

// None: the kernel denies it, or the thread is gone.
std::optional<Nanos> read_clock(ThreadId thread) {
  timespec time{};
  if (::clock_gettime(cpu_clock_of(thread), &time) != 0) return std::nullopt;
  return to_nanos(time);
}

// Without allocation.
Descriptor open_schedstat(const LinuxRoots& roots, ThreadId thread) {
  std::array<char, 4096> path{};
  const auto end =
      fmt::format_to_n(path.data(), path.size() - 1, "{}/{}/schedstat", roots.procfs, static_cast<int>(thread));
  return end.size < path.size() ? Descriptor(::open(path.data(), O_RDONLY | O_CLOEXEC)) : Descriptor();
}

using SchedstatBuffer = std::array<char, 80>;

// Empty: the thread is gone.
std::string_view read_schedstat(const Descriptor& file, SchedstatBuffer& buffer) {
  const ssize_t count = ::pread(file.number(), buffer.data(), buffer.size(), 0);
  return {buffer.data(), count <= 0 ? 0 : static_cast<std::size_t>(count)};
}

// Its first number is CPU time in nanoseconds. None: the thread is gone.
std::optional<Nanos> read_cpu_time(const Descriptor& schedstat) {
  SchedstatBuffer buffer{};
  const std::string_view text = read_schedstat(schedstat, buffer);
  const auto number = parse_integer(text.substr(0, text.find(' ')));
  return number && *number >= 0 ? std::optional(Nanos{*number}) : std::nullopt;
}

class KernelClock : public CpuClock {
 public:
  explicit KernelClock(ThreadId thread) : thread_(thread) {}
  std::optional<Nanos> now() override { return read_clock(thread_); }

 private:
  ThreadId thread_;
};

class SchedstatClock : public CpuClock {
 public:
  explicit SchedstatClock(Descriptor file) : file_(std::move(file)) {}
  std::optional<Nanos> now() override { return read_cpu_time(file_); }

 private:
  Descriptor file_;
};

Error no_cpu_time(ThreadId thread) {
  return Error::environment(fmt::format("cannot read the CPU time of thread {}: it is gone", static_cast<int>(thread)),
                            "threads that end while they are scheduled need no action");
}

// CPU time, time ready to run, times run. All are 0 where the kernel does not count them.
std::optional<Nanos> read_ready_time(const Descriptor& file) {
  SchedstatBuffer buffer{};
  const std::string_view schedstat = read_schedstat(file, buffer);
  const std::size_t first_end = schedstat.find(' ');
  if (first_end == std::string_view::npos) return std::nullopt;
  const std::string_view rest = schedstat.substr(first_end + 1);
  const auto cpu = parse_integer(schedstat.substr(0, first_end));
  const auto ready = parse_integer(rest.substr(0, rest.find(' ')));
  if (!cpu || *cpu <= 0 || !ready || *ready < 0) return std::nullopt;
  return Nanos{*ready};
}

class LinuxThread : public Thread {
 public:
  explicit LinuxThread(std::thread thread) : thread_(std::move(thread)) {}
  ~LinuxThread() override { LinuxThread::join(); }
  void join() override {
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::thread thread_;
};

class LinuxOs : public Os {
 public:
  explicit LinuxOs(LinuxRoots roots) : roots_(std::move(roots)), scheduling_(roots_, calls_), online_cpus_(roots_) {
    forget_thread_on_fork();
  }

  TimePoint now() override;
  Nanos thread_cpu_time() override;
  Result<Nanos> thread_cpu_time(ThreadId thread) override;
  Result<std::unique_ptr<CpuClock>> cpu_clock(ThreadId thread) override;
  std::uint64_t times_blocked() override;
  std::optional<Nanos> ready_time() override;
  std::optional<Nanos> ready_time(ThreadId thread) override;

  WaitResult wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) override;
  void wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) override;
  void wake(const std::atomic<std::uint32_t>& word) override;
  void sleep_until(TimePoint deadline) override;

  ProcessId current_process() override { return ProcessId{::getpid()}; }
  ThreadId current_thread() override;
  ThreadId main_thread(ProcessId process) override { return ThreadId{static_cast<int>(process)}; }
  Result<std::vector<ThreadId>> threads(ProcessId process) override;
  std::unique_ptr<Thread> spawn(const std::string& name, std::function<void()> body) override;
  std::string thread_name(ThreadId thread) override;

  Status set_level(ThreadId thread, Level level) override { return scheduling_.set_level(thread, level); }
  void shift_level(ThreadId thread, Level level) override { scheduling_.shift_level(thread, level); }
  Result<Level> level(ThreadId thread) override { return scheduling_.level(thread); }
  Status set_affinity(ThreadId thread, const CpuSet& cpus) override { return scheduling_.set_affinity(thread, cpus); }
  Result<CpuSet> affinity(ThreadId thread) override { return scheduling_.affinity(thread); }
  Result<SavedScheduling> save_scheduling(ThreadId thread) override { return scheduling_.save(thread); }
  bool is_raised(const SavedScheduling& saved) const override { return Scheduling::is_raised(saved); }
  Status restore_scheduling(const SavedScheduling& saved) override { return scheduling_.restore(saved); }

  Result<Topology> topology() override { return read_topology(roots_); }
  Result<CpuSet> online_cpus() override { return online_cpus_.now(); }
  RealTimeFacts real_time_facts() override;
  HostFacts host_facts() override { return read_host_facts(roots_); }
  int current_cpu() override { return ::sched_getcpu(); }
  PowerState power_state(const CpuSet& cpus) override { return read_power_state(roots_, cpus); }
  std::map<int, Nanos> stolen_time() override { return read_stolen_time(roots_); }
  Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready() override { return os::keep_cpus_ready(roots_); }
  Result<std::unique_ptr<Guardian>> start_guardian() override { return os::start_guardian(roots_); }

 private:
  LinuxRoots roots_;
  KernelCalls calls_;
  Scheduling scheduling_;
  OnlineCpus online_cpus_;
};

TimePoint LinuxOs::now() {
  timespec time{};
  if (::clock_gettime(CLOCK_MONOTONIC, &time) != 0) die("clock_gettime", errno);
  return TimePoint{to_nanos(time)};
}

Nanos LinuxOs::thread_cpu_time() {
  timespec time{};
  if (::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) != 0) die("clock_gettime", errno);
  return to_nanos(time);
}

Result<Nanos> LinuxOs::thread_cpu_time(ThreadId thread) {
  if (may_be_thread(thread)) {
    if (const auto used = read_clock(thread)) return *used;
    if (const auto used = read_cpu_time(open_schedstat(roots_, thread))) return *used;
  }
  return no_cpu_time(thread);
}

Result<std::unique_ptr<CpuClock>> LinuxOs::cpu_clock(ThreadId thread) {
  using Made = std::unique_ptr<CpuClock>;
  if (may_be_thread(thread)) {
    if (read_clock(thread)) return Made(std::make_unique<KernelClock>(thread));
    Descriptor file = open_schedstat(roots_, thread);
    if (read_cpu_time(file)) return Made(std::make_unique<SchedstatClock>(std::move(file)));
  }
  return no_cpu_time(thread);
}

std::uint64_t LinuxOs::times_blocked() {
  rusage usage{};
  if (::getrusage(RUSAGE_THREAD, &usage) != 0) die("getrusage", errno);
  return static_cast<std::uint64_t>(usage.ru_nvcsw);
}

std::optional<Nanos> LinuxOs::ready_time() {
  if (!own_schedstat.valid()) {
    const std::string path = fmt::format("{}/thread-self/schedstat", roots_.procfs);
    own_schedstat = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  }
  return read_ready_time(own_schedstat);
}

// The kernel adds a wait to the sum once the thread has a CPU again.
std::optional<Nanos> LinuxOs::ready_time(ThreadId thread) {
  return may_be_thread(thread) ? read_ready_time(open_schedstat(roots_, thread)) : std::nullopt;
}

WaitResult LinuxOs::wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) {
  const timespec until = to_timespec(deadline);
  const timespec* const timeout = deadline == kNever ? nullptr : &until;
  while (word.load(std::memory_order_acquire) == expected) {
    if (futex(word, FUTEX_WAIT_BITSET, expected, timeout) == 0) continue;
    if (errno == ETIMEDOUT) {
      return word.load(std::memory_order_acquire) == expected ? WaitResult::kTimedOut : WaitResult::kChanged;
    }
    if (errno != EAGAIN && errno != EINTR) die("futex wait", errno);
  }
  return WaitResult::kChanged;
}

void LinuxOs::wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) {
  if (futex(word, FUTEX_WAIT_BITSET, expected, nullptr) == 0 || errno == EAGAIN || errno == EINTR) return;
  die("futex wait", errno);
}

void LinuxOs::wake(const std::atomic<std::uint32_t>& word) {
  if (futex(word, FUTEX_WAKE, INT_MAX, nullptr) < 0) die("futex wake", errno);
}

void LinuxOs::sleep_until(TimePoint deadline) {
  const timespec until = to_timespec(deadline);
  int error = 0;
  do {
    error = ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  } while (error == EINTR);
  if (error != 0) die("clock_nanosleep", error);
}

ThreadId LinuxOs::current_thread() {
  if (cached_thread == 0) cached_thread = static_cast<pid_t>(::syscall(SYS_gettid));
  return ThreadId{cached_thread};
}

Result<std::vector<ThreadId>> LinuxOs::threads(ProcessId process) {
  const int number = static_cast<int>(process);
  const auto numbers = numbered_entries(fmt::format("{}/{}/task", roots_.procfs, number), "");
  if (number <= 0 || !numbers || numbers->empty()) {
    return Error::environment(fmt::format("cannot list the threads of process {}: it is gone", number),
                              fmt::format("start it again; or mount procfs on {} if it is missing", roots_.procfs));
  }
  std::vector<ThreadId> found;
  found.reserve(numbers->size());
  for (const int thread : *numbers) found.push_back(ThreadId{thread});
  return found;
}

std::unique_ptr<Thread> LinuxOs::spawn(const std::string& name, std::function<void()> body) {
  auto run = [this, name = name.substr(0, 15), body = std::move(body)] {
    ::pthread_setname_np(::pthread_self(), name.c_str());
    // A maker that someone else raised (chrt, say) lacks the flag that keeps its level from being inherited.
    const Result<Level> inherited = level(current_thread());
    if (!inherited.ok() || *inherited != Level::kOrdinary) {
      static_cast<void>(set_level(current_thread(), Level::kOrdinary));
    }
    body();
  };
  return std::make_unique<LinuxThread>(std::thread(std::move(run)));
}

std::string LinuxOs::thread_name(ThreadId thread) {
  return read_line(fmt::format("{}/{}/comm", roots_.procfs, static_cast<int>(thread))).value_or("");
}

RealTimeFacts LinuxOs::real_time_facts() {
  RealTimeFacts facts;
  // On a thread of its own: the caller's level is never touched, and nothing is left to restore but a thread that ends.
  const Status permitted = within_thread_limit([&] {
    Status tried = Done{};
    std::thread([&] { tried = scheduling_.try_levels(current_thread()); }).join();
    return tried;
  });
  facts.permitted = permitted.ok();
  if (!permitted.ok()) facts.why_not = permitted.error().message();
  const Reserve reserve = read_reserve(roots_);
  facts.reserved = reserve.fraction;
  facts.reserved_by = reserve.by;
  return facts;
}

}  // namespace

std::unique_ptr<Os> make_linux_os(LinuxRoots roots) { return std::make_unique<LinuxOs>(std::move(roots)); }

}  // namespace ctn::os
