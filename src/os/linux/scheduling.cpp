#include "os/linux/scheduling.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "os/linux/errno_text.h"
#include "os/linux/privilege.h"
#include "os/linux/process.h"
#include "os/linux/restore.h"

namespace ctn::os {
namespace {

constexpr int kDeadlinePolicy = 6;  // SCHED_DEADLINE, which not every <sched.h> names

struct LevelPolicy {
  Level level;
  int policy;
  int priority;
};
constexpr std::array<LevelPolicy, 5> kLevels = {{
    {Level::kOrdinary, SCHED_OTHER, 0},
    {Level::kBackground, SCHED_FIFO, 1},
    {Level::kActive, SCHED_FIFO, 2},
    {Level::kUnscheduled, SCHED_FIFO, 3},
    {Level::kDispatcher, SCHED_FIFO, 4},
}};

static_assert(static_cast<int>(kHighestLevel) == kHighestPriority);

SchedulingPolicy policy_of(Level level) {
  for (const LevelPolicy& known : kLevels) {
    if (known.level == level) return {known.policy, known.priority, true};
  }
  return {SCHED_FIFO, static_cast<int>(level), true};  // a fixed one
}

std::string describe(const SchedulingPolicy& policy) {
  switch (policy.policy) {
    case SCHED_OTHER:
      return "SCHED_OTHER";
    case SCHED_FIFO:
      return fmt::format("SCHED_FIFO {}", policy.priority);
    case SCHED_RR:
      return fmt::format("SCHED_RR {}", policy.priority);
    case SCHED_BATCH:
      return "SCHED_BATCH";
    case SCHED_IDLE:
      return "SCHED_IDLE";
    case kDeadlinePolicy:
      return "SCHED_DEADLINE";
    default:
      return fmt::format("scheduling policy {}", policy.policy);
  }
}

// The kernel takes 0 for the calling thread and negative numbers for no thread; neither is a thread's number.
pid_t kernel_number(ThreadId thread) { return std::max(static_cast<pid_t>(thread), pid_t{-1}); }
bool is_number(ThreadId thread) { return kernel_number(thread) > 0; }

bool is_real_time(int policy) { return policy == SCHED_FIFO || policy == SCHED_RR || policy == kDeadlinePolicy; }

// None: real-time, but not as Catan sets it.
std::optional<Level> level_of(const SchedulingPolicy& found) {
  if (!is_real_time(found.policy)) return Level::kOrdinary;
  for (const LevelPolicy& known : kLevels) {
    if (known.policy == found.policy && known.priority == found.priority) return known.level;
  }
  const bool fixed = found.priority >= static_cast<int>(fixed_level(0)) &&
                     found.priority < static_cast<int>(fixed_level(kFixedLevels));
  if (found.policy == SCHED_FIFO && fixed) return static_cast<Level>(found.priority);
  return std::nullopt;
}

}  // namespace

Error Scheduling::refused(ThreadId thread, const std::string& what, int error) const {
  const std::string place = fmt::format("cannot {} thread {}", what, static_cast<int>(thread));
  if (error == ESRCH) {
    return Error::environment(place + ": it is gone", "threads that end while they are scheduled need no action");
  }
  if (error == EPERM) return Error::environment(place + ": not permitted", how_to_permit(roots_));
  return Error::environment(fmt::format("{}: {}", place, errno_text(error)),
                            "please report it with the kernel's version");
}

Status Scheduling::set_policy(ThreadId thread, const SchedulingPolicy& policy, const std::string& what) {
  if (!is_number(thread)) return refused(thread, what, ESRCH);
  if (const int error = calls_.set_policy(kernel_number(thread), policy)) return refused(thread, what, error);
  return check_policy(thread, policy, what);
}

Status Scheduling::check_policy(ThreadId thread, const SchedulingPolicy& policy, const std::string& what) {
  SchedulingPolicy found;
  if (const int error = calls_.get_policy(kernel_number(thread), found)) return refused(thread, what, error);
  if (found == policy) return Done{};
  return Error::environment(
      fmt::format("cannot {} thread {}: the kernel took {} but the thread is {}{}", what, static_cast<int>(thread),
                  describe(policy), describe(found), found.reset_on_fork ? "" : " without reset-on-fork"),
      "something else sets this thread's scheduling: stop it (a tuning daemon, the thread's own code)");
}

Status Scheduling::set_level(ThreadId thread, Level level) {
  return set_policy(thread, policy_of(level), fmt::format("set level {} for", to_string(level)));
}

void Scheduling::shift_level(ThreadId thread, Level level) {
  if (is_number(thread)) static_cast<void>(calls_.set_policy(kernel_number(thread), policy_of(level)));
}

Status Scheduling::try_levels(ThreadId thread) {
  Status raised = set_level(thread, kHighestLevel);
  static_cast<void>(set_level(thread, Level::kOrdinary));
  return raised;
}

Result<Level> Scheduling::level(ThreadId thread) {
  const char* const what = "read the level of";
  if (!is_number(thread)) return refused(thread, what, ESRCH);
  SchedulingPolicy found;
  if (const int error = calls_.get_policy(kernel_number(thread), found)) return refused(thread, what, error);
  if (const std::optional<Level> level = level_of(found)) return *level;
  return Error::environment(
      fmt::format("thread {} is at none of Catan's levels but {}", static_cast<int>(thread), describe(found)),
      "leave real-time scheduling to Catan: remove chrt or the call that raises this thread");
}

Status Scheduling::set_affinity(ThreadId thread, const CpuSet& cpus) {
  if (cpus.empty()) return Error::caller("a thread cannot be pinned to no CPU", "name at least one CPU");
  if (cpus.cpus().front() < 0) {
    return Error::caller(fmt::format("{} is no CPU number", cpus.cpus().front()), "CPU numbers start at 0");
  }
  const std::string what = fmt::format("bind to CPUs {}", to_string(cpus));
  if (!is_number(thread)) return refused(thread, what, ESRCH);
  const int error = calls_.set_affinity(kernel_number(thread), to_mask(cpus));
  if (error != 0 && error != EINVAL) return refused(thread, what, error);
  const Result<CpuSet> found = affinity(thread);
  if (!found.ok()) return found.error();
  if (error == 0 && *found == cpus) return Done{};
  const std::optional<std::string> online = read_line(roots_.sysfs + "/devices/system/cpu/online");
  return Error::environment(
      fmt::format("cannot {} thread {}: it may use CPUs {}", what, static_cast<int>(thread), to_string(*found)),
      fmt::format("name CPUs that are online ({}) and in this process's cpuset",
                  online.value_or("see /sys/devices/system/cpu/online")));
}

Result<CpuSet> Scheduling::affinity(ThreadId thread) {
  const char* const what = "read the CPUs of";
  if (!is_number(thread)) return refused(thread, what, ESRCH);
  CpuMask cpus{};
  if (const int error = calls_.get_affinity(kernel_number(thread), cpus)) return refused(thread, what, error);
  return to_cpu_set(cpus);
}

Result<SavedScheduling> Scheduling::save(ThreadId thread) {
  const char* const what = "read the scheduling of";
  if (!is_number(thread)) return refused(thread, what, ESRCH);
  const std::optional<std::uint64_t> started = start_time(thread, roots_);
  if (!started) return refused(thread, what, ESRCH);
  SchedulingPolicy policy;
  if (const int error = calls_.get_policy(kernel_number(thread), policy)) return refused(thread, what, error);
  if (policy.policy == kDeadlinePolicy) {
    return Error::environment(
        fmt::format("thread {} is SCHED_DEADLINE, which Catan could not give back to it", static_cast<int>(thread)),
        "start it under ordinary scheduling");
  }
  SavedScheduling saved{thread, *started, policy.policy, policy.priority, 0, policy.reset_on_fork, {}};
  if (const int error = calls_.get_nice(kernel_number(thread), saved.nice)) return refused(thread, what, error);
  Result<CpuSet> cpus = affinity(thread);
  if (!cpus.ok()) return cpus.error();
  saved.affinity = std::move(*cpus);
  return saved;
}

bool Scheduling::is_raised(const SavedScheduling& saved) {
  const std::optional<Level> level = level_of({saved.policy, saved.priority, saved.reset_on_fork});
  return level && *level != Level::kOrdinary && saved.reset_on_fork;
}

Status Scheduling::restore(const SavedScheduling& saved) {
  const ThreadId thread = saved.thread;
  const char* const what = "restore the scheduling of";
  const RestoreErrors errors = os::restore(calls_, roots_.procfs.c_str(), to_saved_thread(saved));
  for (const int error : {errors.policy, errors.nice}) {
    if (error != 0) return refused(thread, what, error);
  }
  if (Status given = check_policy(thread, errors.given, what); !given.ok()) return given;
  return errors.cpus == 0 ? Status(Done{}) : refused(thread, "restore the CPUs of", errors.cpus);
}

}  // namespace ctn::os
