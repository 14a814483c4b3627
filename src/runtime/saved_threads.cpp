#include "runtime/saved_threads.h"

namespace ctn::runtime {

bool SavedThreads::has(const os::SavedScheduling& thread) const {
  const auto known = saved_.find(thread.thread);
  return known != saved_.end() && known->second.same_thread(thread);
}

void SavedThreads::restore(os::ThreadId thread) const {
  const auto saved = saved_.find(thread);
  if (saved != saved_.end()) static_cast<void>(scheduling_.restore_scheduling(saved->second));
}

void SavedThreads::restore_all() const {
  for (const auto& [thread, saved] : saved_) static_cast<void>(scheduling_.restore_scheduling(saved));
}

void SavedThreads::restore_levels() const {
  for (const auto& [thread, saved] : saved_) {
    const Result<os::CpuSet> cpus = scheduling_.affinity(thread);
    static_cast<void>(scheduling_.restore_scheduling(saved));
    if (cpus) static_cast<void>(scheduling_.set_affinity(thread, *cpus));
  }
}

void SavedThreads::restore_unknown(os::ThreadId thread, bool raised, os::ThreadId like) const {
  if (raised) static_cast<void>(scheduling_.set_level(thread, os::Level::kOrdinary));
  const auto saved = saved_.find(like);
  if (saved != saved_.end()) static_cast<void>(scheduling_.set_affinity(thread, saved->second.affinity));
}

}  // namespace ctn::runtime
