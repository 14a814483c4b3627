#include "os/linux/kernel_calls.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <utility>
#include <vector>

namespace ctn::os {
namespace {

// A kernel of any size answers within this.
constexpr std::size_t kMaxCpus = std::size_t{1} << 17;
constexpr std::size_t kUsualCpus = 1024;

struct FreeCpuMask {
  void operator()(cpu_set_t* mask) const { CPU_FREE(mask); }
};
using CpuMask = std::unique_ptr<cpu_set_t, FreeCpuMask>;

}  // namespace

// The system calls themselves, because the C library's wrappers of that name need not be about threads (musl's refuse).
int KernelCalls::set_policy(pid_t thread, const SchedulingPolicy& policy) {
  sched_param parameters{};
  parameters.sched_priority = policy.priority;
  const int flag = policy.reset_on_fork ? SCHED_RESET_ON_FORK : 0;
  return ::syscall(SYS_sched_setscheduler, thread, policy.policy | flag, &parameters) == 0 ? 0 : errno;
}

int KernelCalls::get_policy(pid_t thread, SchedulingPolicy& policy) {
  const long found = ::syscall(SYS_sched_getscheduler, thread);
  if (found < 0) return errno;
  sched_param parameters{};
  if (::syscall(SYS_sched_getparam, thread, &parameters) != 0) return errno;
  const int bits = static_cast<int>(found);
  policy = {bits & ~SCHED_RESET_ON_FORK, parameters.sched_priority, (bits & SCHED_RESET_ON_FORK) != 0};
  return 0;
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

int KernelCalls::set_affinity(pid_t thread, const CpuSet& cpus) {
  const std::size_t count = cpus.empty() ? 1 : static_cast<std::size_t>(cpus.cpus().back()) + 1;
  const CpuMask mask(CPU_ALLOC(count));
  if (!mask) return ENOMEM;
  const std::size_t bytes = CPU_ALLOC_SIZE(count);
  CPU_ZERO_S(bytes, mask.get());
  for (const int cpu : cpus.cpus()) CPU_SET_S(static_cast<std::size_t>(cpu), bytes, mask.get());
  return ::sched_setaffinity(thread, bytes, mask.get()) == 0 ? 0 : errno;
}

int KernelCalls::get_affinity(pid_t thread, CpuSet& cpus) {
  int error = EINVAL;
  // The kernel says EINVAL when it has more CPUs than the mask has bits.
  for (std::size_t count = kUsualCpus; error == EINVAL && count <= kMaxCpus; count *= 2) {
    const CpuMask mask(CPU_ALLOC(count));
    if (!mask) return ENOMEM;
    const std::size_t bytes = CPU_ALLOC_SIZE(count);
    CPU_ZERO_S(bytes, mask.get());
    error = ::sched_getaffinity(thread, bytes, mask.get()) == 0 ? 0 : errno;
    if (error != 0) continue;
    std::vector<int> numbers;
    for (std::size_t cpu = 0; cpu < count; ++cpu) {
      if (CPU_ISSET_S(cpu, bytes, mask.get())) numbers.push_back(static_cast<int>(cpu));
    }
    cpus = CpuSet(std::move(numbers));
  }
  return error;
}

}  // namespace ctn::os
