#include "common/turns.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "common/priority_mutex.h"

namespace catan_ros {
namespace {

constexpr std::chrono::milliseconds kLookForStop{50};
constexpr std::chrono::milliseconds kOneOfSeveral{1};
constexpr std::chrono::milliseconds kNoSpinnerYet{2};

}  // namespace

// A slot is a turn from when it is brought until it is taken along; which thread brought it does not matter.
class Turns::Slots {
 public:
  Slots() = default;
  // So many from the beginning, and no more.
  explicit Slots(std::size_t count) : fixed_(true) {
    std::fill_n(is_there_.begin(), std::min(count, kMaxSpinners), true);
  }

  // The index of a new turn, which the calling thread holds; -1: there are enough.
  int bring() {
    if (fixed_) return -1;
    for (std::size_t slot = 0; slot < kMaxSpinners; ++slot) {
      if (is_there_[slot].load() || !mutexes_[slot].try_lock()) continue;
      if (!is_there_[slot].exchange(true)) return static_cast<int>(slot);
      mutexes_[slot].unlock();
    }
    return -1;
  }

  // The index of one that the calling thread holds now; -1: `stop` became true. Null: it never does.
  int take_any(const std::atomic<bool>* stop) {
    for (std::size_t next = 0;; ++next) {
      std::size_t there = 0;
      for (std::size_t slot = 0; slot < kMaxSpinners; ++slot) {
        if (!is_there_[slot].load()) continue;
        ++there;
        if (mutexes_[slot].try_lock() && is_still_there(slot)) return static_cast<int>(slot);
      }
      if (stop != nullptr && stop->load()) return -1;
      if (there == 0) {
        std::this_thread::sleep_for(kNoSpinnerYet);
        continue;
      }
      const std::size_t slot = find(next % there);
      const auto patience = there == 1 ? kLookForStop : kOneOfSeveral;
      if (mutexes_[slot].try_lock_for(patience) && is_still_there(slot)) return static_cast<int>(slot);
    }
  }

  // By the thread that holds it.
  void give_back(int index) { mutexes_[static_cast<std::size_t>(index)].unlock(); }
  void take_along(int index) {
    is_there_[static_cast<std::size_t>(index)].store(false);
    give_back(index);
  }

 private:
  // Of those that are there; any, where it went meanwhile.
  std::size_t find(std::size_t number) const {
    for (std::size_t slot = 0; slot < kMaxSpinners; ++slot) {
      if (is_there_[slot].load() && number-- == 0) return slot;
    }
    return 0;
  }

  // Of a slot whose mutex was just got: its turn may have been taken along before.
  bool is_still_there(std::size_t slot) {
    if (is_there_[slot].load()) return true;
    mutexes_[slot].unlock();
    return false;
  }

  const bool fixed_ = false;
  std::array<PriorityMutex, kMaxSpinners> mutexes_;
  std::array<std::atomic<bool>, kMaxSpinners> is_there_{};  // changed by who holds the mutex
};

struct Turns::Held {
  std::shared_ptr<Slots> slots;
  int index = -1;        // of the turn that it holds; -1: none
  bool asked = false;    // whether it brings its own along
  bool brought = false;  // it does
};

// A spinner that ends holds a turn, as between two calls of spinOnce(). It was any; where the thread brought none, it
// is another's.
class Turns::HeldByThread {
 public:
  HeldByThread() = default;
  ~HeldByThread() {
    for (const Held& one : all_) {
      if (one.index < 0) continue;
      one.brought ? one.slots->take_along(one.index) : one.slots->give_back(one.index);
    }
  }
  HeldByThread(const HeldByThread&) = delete;
  HeldByThread& operator=(const HeldByThread&) = delete;

  Held& of(const std::shared_ptr<Slots>& slots) {
    const auto found = std::find_if(all_.begin(), all_.end(), [&](const Held& one) { return one.slots == slots; });
    return found != all_.end() ? *found : all_.emplace_back(Held{slots});
  }

 private:
  std::vector<Held> all_;
};

Turns::Turns() : slots_(std::make_shared<Slots>()) {}
Turns::Turns(std::size_t count) : slots_(std::make_shared<Slots>(count)) {}

Turns::Held& Turns::held() const {
  thread_local HeldByThread all;
  return all.of(slots_);
}

// A turn of the thread's own, which it holds; at its first call, unless there are enough.
void Turns::bring(Held& own) {
  if (std::exchange(own.asked, true)) return;
  own.index = slots_->bring();
  own.brought = own.index >= 0;
}

void Turns::enter() {
  Held& own = held();
  if (own.index < 0) bring(own);
  // That of a callback which spins, too, bound or not: others may run meanwhile.
  give_back();
}

// A thread that has begun to spin before there were turns brings its own now.
void Turns::leave() {
  Held& own = held();
  if (own.index < 0) bring(own);
  if (own.index < 0) own.index = slots_->take_any(nullptr);
}

bool Turns::begin() {
  if (held().index >= 0) return false;
  leave();
  return true;
}

void Turns::end(bool taken) {
  if (taken) give_back();
}

bool Turns::take(const std::atomic<bool>& stop) {
  Held& own = held();
  if (own.index < 0) own.index = slots_->take_any(&stop);
  // A thread of a node brings none along, also where its callback spins.
  own.asked = true;
  return own.index >= 0;
}

void Turns::give_back() {
  Held& own = held();
  if (own.index < 0) return;
  slots_->give_back(own.index);
  own.index = -1;
}

}  // namespace catan_ros
