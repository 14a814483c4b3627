// The Guard of a FakeOs: the guardian is a promise, kept by restore_watched().
#include <cassert>
#include <utility>

#include "os/fake/fake_os.h"
#include "os/fake/fake_task.h"

namespace ctn::os {

class FakeOs::FakeGuard : public Guard {
 public:
  explicit FakeGuard(FakeOs& os) : os_(os) {}
  ~FakeGuard() override {
    static_cast<void>(FakeGuard::tend());
    os_.restore_watched();
    const Lock lock(os_.mutex_);
    os_.has_guard_ = os_.has_guardian_ = false;
  }
  FakeGuard(const FakeGuard&) = delete;
  FakeGuard& operator=(const FakeGuard&) = delete;

  bool watch(ThreadId thread, const SavedScheduling& before) override {
    const Lock lock(os_.mutex_);
    stand_in();
    const bool room = os_.watched_.contains(thread) || os_.watched_.size() < os_.guard_room_;
    if (!room || os_.find(thread) == nullptr) return false;
    os_.watched_[thread] = before;
    os_.guard_calls_.push_back({os_.now_, thread, before});
    return true;
  }

  void forget(ThreadId thread) override {
    const Lock lock(os_.mutex_);
    if (os_.watched_.erase(thread) > 0) os_.guard_calls_.push_back({os_.now_, thread, std::nullopt});
  }

  Status tend() override {
    const Lock lock(os_.mutex_);
    stand_in();
    return Done{};
  }

  int replaced() const override {
    const Lock lock(os_.mutex_);
    return replaced_;
  }

 private:
  void stand_in() {
    if (!std::exchange(os_.has_guardian_, true)) ++replaced_;
  }

  FakeOs& os_;
  int replaced_ = 0;
};

Result<std::unique_ptr<Guard>> FakeOs::start_guard() {
  const Lock lock(mutex_);
  assert(!has_guard_);
  has_guard_ = has_guardian_ = true;
  return std::unique_ptr<Guard>(std::make_unique<FakeGuard>(*this));
}

void FakeOs::restore_watched() {
  std::map<ThreadId, SavedScheduling> watched;
  {
    const Lock lock(mutex_);
    if (!has_guardian_) return;
    watched = std::exchange(watched_, {});
  }
  for (const auto& [thread, before] : watched) static_cast<void>(restore_scheduling(thread, before));
}

void FakeOs::end_guardian() {
  const Lock lock(mutex_);
  has_guardian_ = false;
}

void FakeOs::set_guard_room(std::size_t room) {
  const Lock lock(mutex_);
  guard_room_ = room;
}

std::vector<ThreadId> FakeOs::watched() const {
  const Lock lock(mutex_);
  std::vector<ThreadId> threads;
  threads.reserve(watched_.size());
  for (const auto& [thread, before] : watched_) threads.push_back(thread);
  return threads;
}

std::vector<FakeOs::GuardCall> FakeOs::guard_calls() const {
  const Lock lock(mutex_);
  return guard_calls_;
}

}  // namespace ctn::os
