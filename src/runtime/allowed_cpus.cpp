#include "runtime/allowed_cpus.h"

#include <vector>

namespace ctn::runtime {

void AllowedCpus::watch(os::ThreadId thread) {
  if (enforcer_.has_placed(thread)) return;
  const Result<os::CpuSet> cpus = os_.affinity(thread);
  if (!cpus) return;  // gone
  const std::lock_guard lock(mutex_);
  before_.insert_or_assign(thread, *cpus);
}

void AllowedCpus::forget(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  before_.erase(thread);
}

Result<os::CpuSet> AllowedCpus::now() const {
  const Result<os::CpuSet> online = os_.online_cpus();
  if (!online) return online;
  std::vector<int> allowed = online->cpus();
  const std::lock_guard lock(mutex_);
  for (const auto& [thread, before] : before_) {
    // Asked on both sides: it may just be placed, or get back what it had.
    if (enforcer_.has_placed(thread)) continue;
    const Result<os::CpuSet> cpus = os_.affinity(thread);
    if (!cpus || enforcer_.has_placed(thread)) continue;
    std::erase_if(allowed, [&had = before, &cpus](int cpu) { return had.contains(cpu) && !cpus->contains(cpu); });
  }
  return os::CpuSet(std::move(allowed));
}

}  // namespace ctn::runtime
