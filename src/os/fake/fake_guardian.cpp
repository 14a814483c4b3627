// The Guardian of a FakeOs: the guardian is a promise, kept by restore_watched().
#include <cassert>
#include <utility>

#include "os/fake/fake_os.h"
#include "os/fake/fake_task.h"

namespace ctn::os {

class FakeOs::FakeGuardian : public Guardian {
 public:
  explicit FakeGuardian(FakeOs& os) : os_(os) {}
  ~FakeGuardian() override {
    static_cast<void>(FakeGuardian::ensure_running());
    os_.restore_watched();
    const Lock lock(os_.mutex_);
    os_.guardian_started_ = os_.guardian_running_ = false;
  }
  FakeGuardian(const FakeGuardian&) = delete;
  FakeGuardian& operator=(const FakeGuardian&) = delete;

  bool watch(const SavedScheduling& before) override {
    const Lock lock(os_.mutex_);
    stand_in();
    const bool room = os_.watched_.contains(before.thread) || os_.watched_.size() < os_.guardian_capacity_;
    if (!room || os_.find(before) == nullptr) return false;
    os_.watched_[before.thread] = before;
    os_.guardian_calls_.push_back({os_.now_, before.thread, before});
    return true;
  }

  void forget(ThreadId thread) override {
    const Lock lock(os_.mutex_);
    if (os_.watched_.erase(thread) > 0) os_.guardian_calls_.push_back({os_.now_, thread, std::nullopt});
  }

  Status ensure_running() override {
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
    if (!std::exchange(os_.guardian_running_, true)) ++replaced_;
  }

  FakeOs& os_;
  int replaced_ = 0;
};

Result<std::unique_ptr<Guardian>> FakeOs::start_guardian() {
  const Lock lock(mutex_);
  assert(!guardian_started_);
  guardian_started_ = guardian_running_ = true;
  return std::unique_ptr<Guardian>(std::make_unique<FakeGuardian>(*this));
}

void FakeOs::restore_watched() {
  std::map<ThreadId, SavedScheduling> watched;
  {
    const Lock lock(mutex_);
    if (!guardian_running_) return;
    watched = std::exchange(watched_, {});
  }
  for (const auto& [thread, before] : watched) static_cast<void>(restore_scheduling(before));
}

void FakeOs::end_guardian() {
  const Lock lock(mutex_);
  guardian_running_ = false;
}

void FakeOs::set_guardian_capacity(std::size_t room) {
  const Lock lock(mutex_);
  guardian_capacity_ = room;
}

std::vector<ThreadId> FakeOs::watched() const {
  const Lock lock(mutex_);
  std::vector<ThreadId> threads;
  threads.reserve(watched_.size());
  for (const auto& [thread, before] : watched_) threads.push_back(thread);
  return threads;
}

std::vector<FakeOs::GuardianCall> FakeOs::guardian_calls() const {
  const Lock lock(mutex_);
  return guardian_calls_;
}

}  // namespace ctn::os
