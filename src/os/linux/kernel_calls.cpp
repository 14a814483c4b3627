#include "os/linux/kernel_calls.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <utility>
#include <vector>

namespace ctn::os {

CpuMask to_mask(const CpuSet& cpus) {
  CpuMask mask{};
  for (const int cpu : cpus.cpus()) {
    const auto number = static_cast<std::size_t>(cpu);
    if (cpu >= 0 && number < kMaxCpus) mask.at(number / 64) |= std::uint64_t{1} << number % 64;
  }
  return mask;
}

CpuSet to_cpu_set(const CpuMask& mask) {
  std::vector<int> numbers;
  // Controllers, which move threads, have no time to look at every bit.
  for (std::size_t word = 0; word < mask.size(); ++word) {
    for (std::uint64_t bits = mask.at(word); bits != 0; bits &= bits - 1) {
      numbers.push_back(static_cast<int>(word) * 64 + std::countr_zero(bits));
    }
  }
  return CpuSet(std::move(numbers));
}

CpuMask all_cpus() {
  CpuMask mask;
  mask.fill(~std::uint64_t{0});
  return mask;
}

// The system calls themselves, because the C library's wrappers of that name need not be about threads (musl's refuse).
int KernelCalls::set_policy(pid_t thread, const SchedulingPolicy& policy) {
  sched_param parameters{};
  parameters.sched_priority = policy.priority;
  const int flag = policy.reset_on_fork ? SCHED_RESET_ON_FORK : 0;
  return ::syscall(SYS_sched_setscheduler, thread, policy.policy | flag, &parameters) == 0 ? 0 : errno;
}

int KernelCalls::look_at_policy(pid_t thread, SchedulingPolicy& policy) {
  const long found = ::syscall(SYS_sched_getscheduler, thread);
  if (found < 0) return errno;
  sched_param parameters{};
  if (::syscall(SYS_sched_getparam, thread, &parameters) != 0) return errno;
  const int bits = static_cast<int>(found);
  policy = {bits & ~SCHED_RESET_ON_FORK, parameters.sched_priority, (bits & SCHED_RESET_ON_FORK) != 0};
  return 0;
}

// A policy and a priority that do not belong together could not be given back to the thread. They are read until they
// do; each further attempt takes another change at that moment.
int KernelCalls::get_policy(pid_t thread, SchedulingPolicy& policy) {
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (const int error = look_at_policy(thread, policy)) return error;
    const bool has_priority = policy.policy == SCHED_FIFO || policy.policy == SCHED_RR;
    if (has_priority == (policy.priority > 0)) return 0;
  }
  return EAGAIN;
}

int KernelCalls::set_nice(pid_t thread, int nice) {
  return ::setpriority(PRIO_PROCESS, static_cast<id_t>(thread), nice) == 0 ? 0 : errno;
}

int KernelCalls::get_nice(pid_t thread, int& nice) {
  errno = 0;
  const int found = ::getpriority(PRIO_PROCESS, static_cast<id_t>(thread));
  if (found == -1 && errno != 0) return errno;
  nice = found;
  return 0;
}

int KernelCalls::set_affinity(pid_t thread, const CpuMask& cpus) {
  return ::syscall(SYS_sched_setaffinity, thread, sizeof cpus, cpus.data()) == 0 ? 0 : errno;
}

int KernelCalls::get_affinity(pid_t thread, CpuMask& cpus) {
  cpus = {};  // the kernel writes as many bits as it has CPUs
  return ::syscall(SYS_sched_getaffinity, thread, sizeof cpus, cpus.data()) >= 0 ? 0 : errno;
}

}  // namespace ctn::os
