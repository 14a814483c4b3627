#include "runtime/enforcer.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace ctn::runtime {

Enforcer::Enforcer(os::Os& os, bool real_time, std::function<void(const std::string&)> on_refusal)
    : os_(os), real_time_(real_time), on_refusal_(std::move(on_refusal)) {}

Status Enforcer::apply(os::ThreadId thread, os::Level level, const os::CpuSet& cpus) {
  const std::lock_guard lock(mutex_);
  if (!saved_.contains(thread)) {
    Result<os::SavedScheduling> before = os_.save_scheduling(thread);
    if (!before) return Done{};  // gone
    saved_.emplace(thread, std::move(*before));
  }
  if (Status placed = os_.set_affinity(thread, cpus); !placed) {
    if (!os_.affinity(thread)) return Done{};  // gone meanwhile
    return placed;
  }
  if (!real_time() || level == os::Level::kOrdinary) return Done{};
  if (const Status raised = os_.set_level(thread, level); !raised && os_.level(thread))
    refuse(raised.error().message());
  return Done{};
}

void Enforcer::set_level_now(os::ThreadId thread, os::Level level) {
  if (real_time()) os_.shift_level(thread, level);
}

void Enforcer::move_now(os::ThreadId thread, const os::CpuSet& cpus) {
  // Best effort: the thread may be gone, and a dispatcher has nobody to tell.
  static_cast<void>(os_.set_affinity(thread, cpus));
}

void Enforcer::refuse(const std::string& why) {
  real_time_.store(false, std::memory_order_release);
  for (const auto& [thread, before] : saved_) {
    const Result<os::CpuSet> cpus = os_.affinity(thread);
    static_cast<void>(os_.restore_scheduling(thread, before));
    if (cpus) static_cast<void>(os_.set_affinity(thread, *cpus));
  }
  if (on_refusal_) on_refusal_(why);
}

void Enforcer::release_all() {
  const std::lock_guard lock(mutex_);
  // The number of a thread that has ended may be another process's by now.
  const Result<std::vector<os::ThreadId>> mine = os_.threads(os_.current_process());
  for (const auto& [thread, before] : saved_) {
    if (mine && !std::binary_search(mine->begin(), mine->end(), thread)) continue;
    static_cast<void>(os_.restore_scheduling(thread, before));
  }
  saved_.clear();
}

}  // namespace ctn::runtime
