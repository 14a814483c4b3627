#include "common/unbound_calls.h"

#include <chrono>
#include <mutex>

namespace catan_ros {
namespace {

constexpr std::chrono::milliseconds kLookWhetherToStop{50};

}  // namespace

void UnboundCalls::begin() {
  const std::lock_guard lock(mutex_);
  ++under_way_;
}

void UnboundCalls::end() {
  const std::lock_guard lock(mutex_);
  if (--under_way_ == 0) changed_.notify_all();
}

void UnboundCalls::wait_for_ends(const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  while (under_way_ > 0 && !stop.load()) {
    changed_.wait_until(mutex_, std::chrono::steady_clock::now() + kLookWhetherToStop);
  }
}

}  // namespace catan_ros
