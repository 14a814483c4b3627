#include "runtime/placed_threads.h"

namespace ctn::runtime {

// Never destroyed: threads of sessions may outlive static objects.
PlacedThreads& PlacedThreads::of_process() {
  static PlacedThreads* const kThreads = new PlacedThreads;
  return *kThreads;
}

void PlacedThreads::add(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  ++enforcers_[thread];
}

void PlacedThreads::remove(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  const auto placed = enforcers_.find(thread);
  if (placed != enforcers_.end() && --placed->second == 0) enforcers_.erase(placed);
}

bool PlacedThreads::has(os::ThreadId thread) const {
  const std::lock_guard lock(mutex_);
  return enforcers_.contains(thread);
}

}  // namespace ctn::runtime
