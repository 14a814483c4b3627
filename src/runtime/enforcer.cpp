#include "runtime/enforcer.h"

#include <utility>

#include "runtime/placed_threads.h"

namespace ctn::runtime {

Enforcer::Enforcer(os::Os& os, bool real_time, std::unique_ptr<os::Guardian> guardian, driver::Notices* notices)
    : os_(os), real_time_(real_time), notices_(notices), saved_(os), guardian_(std::move(guardian)) {}

void Enforcer::tell(const std::string& kind, const std::string& detail) {
  if (notices_ != nullptr) notices_->add({os_.now(), kind, detail});
}

Status Enforcer::apply(os::ThreadId thread, os::Level level, const os::CpuSet& cpus, os::ProcessId owner) {
  const std::lock_guard lock(mutex_);
  if (ended_) return Done{};
  Result<os::SavedScheduling> now = os_.save_scheduling(thread);
  if (!now) return Done{};  // gone
  if (!saved_.has(*now)) {
    // A thread that no guardian watches is left alone: it would stay as it is put if this process were killed.
    if (owner != os_.current_process() && !(guardian_ && guardian_->watch(*now))) {
      if (!os_.affinity(thread)) return Done{};  // gone meanwhile
      return Error::environment(
          "there is no guardian for threads of other processes",
          "check whether this system lets the server start processes, and schedule fewer threads");
    }
    if (!saved_.has(now->thread)) PlacedThreads::of_process().add(now->thread);
    saved_.save(std::move(*now));
  }
  if (Status placed = os_.set_affinity(thread, cpus); !placed) {
    if (!os_.affinity(thread)) return Done{};  // gone meanwhile
    return placed;
  }
  if (level != os::Level::kOrdinary) raise_or_refuse(thread, level, attempts_of(owner));
  return Done{};
}

// A program whose server was away restores its threads for some seconds, and may do so just as one is raised here.
int Enforcer::attempts_of(os::ProcessId owner) const { return owner == os_.current_process() ? 1 : 3; }

void Enforcer::try_level(os::ThreadId thread, os::Level level, os::ProcessId owner) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  raise_or_refuse(thread, level, attempts_of(owner));
  if (real_time()) os_.shift_level(thread, os::Level::kOrdinary);
}

void Enforcer::raise(os::ThreadId thread, os::Level level) {
  const std::lock_guard lock(mutex_);
  if (!ended_) raise_or_refuse(thread, level, 1);
}

void Enforcer::raise_or_refuse(os::ThreadId thread, os::Level level, int attempts) {
  if (!real_time()) return;
  Status raised = os_.set_level(thread, level);
  for (int attempt = 1; !raised && attempt < attempts; ++attempt) raised = os_.set_level(thread, level);
  if (!raised && os_.level(thread)) refuse(raised.error().message());
}

void Enforcer::set_level_now(os::ThreadId thread, os::Level level) {
  if (!real_time()) return;
  os_.shift_level(thread, level);
  // Levels may have been refused just before: all threads were lowered then, and this one would stay raised.
  if (level != os::Level::kOrdinary && !real_time()) os_.shift_level(thread, os::Level::kOrdinary);
}

void Enforcer::move_now(os::ThreadId thread, const os::CpuSet& cpus) {
  // Best effort: the thread may be gone, and a controller has nowhere to report it.
  static_cast<void>(os_.set_affinity(thread, cpus));
}

bool Enforcer::keep_on(os::ThreadId thread, const os::CpuSet& cpus) {
  const Result<os::CpuSet> now = os_.affinity(thread);
  return now && *now != cpus && os_.set_affinity(thread, cpus).ok();
}

void Enforcer::refuse(const std::string& why) {
  real_time_.store(false, std::memory_order_release);
  saved_.restore_levels();
  tell("rates-only", why);
}

void Enforcer::check_guardian() {
  const std::lock_guard lock(mutex_);
  if (!guardian_) return;
  if (const Status running = guardian_->ensure_running(); !running) {
    if (!std::exchange(guardian_missing_, true)) tell("guard", running.error().message());
    return;
  }
  guardian_missing_ = false;
  if (const int replaced = guardian_->replaced(); std::exchange(guardians_replaced_, replaced) != replaced) {
    tell("guard",
         "another program ended the guardian, which restores the scheduling of threads if this process is killed; "
         "another was started");
  }
}

void Enforcer::restore(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  if (!saved_.has(thread)) return;
  saved_.restore(thread);
  if (guardian_) guardian_->forget(thread);
  saved_.forget(thread);
  PlacedThreads::of_process().remove(thread);
}

void Enforcer::restore_all() {
  const std::lock_guard lock(mutex_);
  saved_.restore_all();
}

void Enforcer::restore_for_good() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  saved_.restore_all();
  if (guardian_) saved_.for_each_thread([this](os::ThreadId thread) { guardian_->forget(thread); });
  saved_.for_each_thread([](os::ThreadId thread) { PlacedThreads::of_process().remove(thread); });
  saved_.clear();
}

}  // namespace ctn::runtime
