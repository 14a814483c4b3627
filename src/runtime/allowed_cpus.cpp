#include "runtime/allowed_cpus.h"

#include <vector>

#include "runtime/placed_threads.h"

namespace ctn::runtime {

// Nothing: it is gone, or placed. That is asked on both sides: it may just be placed, or get back what it had.
std::optional<os::CpuSet> AllowedCpus::of_its_own(os::ThreadId thread) const {
  if (PlacedThreads::of_process().has(thread)) return std::nullopt;
  const Result<os::CpuSet> cpus = os_.affinity(thread);
  if (!cpus || PlacedThreads::of_process().has(thread)) return std::nullopt;
  return *cpus;
}

void AllowedCpus::watch(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  before_.insert_or_assign(thread, of_its_own(thread));
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
  for (auto& [thread, before] : before_) {
    const std::optional<os::CpuSet> cpus = of_its_own(thread);
    if (!cpus) continue;
    if (!before) before = cpus;
    std::erase_if(allowed, [&had = *before, &cpus](int cpu) { return had.contains(cpu) && !cpus->contains(cpu); });
  }
  return os::CpuSet(std::move(allowed));
}

}  // namespace ctn::runtime
