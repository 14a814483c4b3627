#include "os/linux/restore.h"

#include <cerrno>

#include "os/linux/process.h"

namespace ctn::os {
namespace {

int restore_policy(KernelCalls& kernel, pid_t thread, SchedulingPolicy& wanted) {
  SchedulingPolicy found;
  if (const int error = kernel.get_policy(thread, found)) return error;
  if (found == wanted) return 0;
  const int error = kernel.set_policy(thread, wanted);
  if (error != EPERM || !found.reset_on_fork || wanted.reset_on_fork) return error;
  wanted.reset_on_fork = true;
  return kernel.set_policy(thread, wanted);
}

int restore_nice(KernelCalls& kernel, pid_t thread, int wanted) {
  int found = 0;
  if (const int error = kernel.get_nice(thread, found)) return error;
  return found == wanted ? 0 : kernel.set_nice(thread, wanted);
}

int restore_cpus(KernelCalls& kernel, pid_t thread, const CpuMask& wanted) {
  CpuMask found{};
  if (const int error = kernel.get_affinity(thread, found)) return error;
  if (found == wanted || wanted == CpuMask{}) return 0;
  const int error = kernel.set_affinity(thread, wanted);
  return error == EINVAL ? kernel.set_affinity(thread, all_cpus()) : error;
}

}  // namespace

SavedThread to_saved_thread(const SavedScheduling& saved) {
  return {saved.thread,
          saved.started,
          {saved.policy, saved.priority, saved.reset_on_fork},
          saved.nice,
          to_mask(saved.affinity)};
}

RestoreErrors restore(KernelCalls& kernel, const char* procfs, const SavedThread& saved) {
  const auto thread = static_cast<pid_t>(saved.thread);
  if (read_start_time(procfs, saved.thread) != saved.started) return {ESRCH, ESRCH, ESRCH, saved.policy};
  RestoreErrors errors;
  errors.given = saved.policy;
  errors.policy = restore_policy(kernel, thread, errors.given);
  errors.nice = restore_nice(kernel, thread, saved.nice);
  errors.cpus = restore_cpus(kernel, thread, saved.cpus);
  return errors;
}

}  // namespace ctn::os
