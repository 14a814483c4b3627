#include "common/turns.h"

#include <algorithm>
#include <thread>
#include <vector>

namespace catan_ros {
namespace {

constexpr std::chrono::milliseconds kLookForStop{50};
constexpr std::chrono::milliseconds kOneOfSeveral{1};
constexpr std::chrono::milliseconds kNoSpinnerYet{2};

}  // namespace

Turns::Held& Turns::held() const {
  thread_local std::vector<Held> all;
  const auto found = std::find_if(all.begin(), all.end(), [this](const Held& one) { return one.turns == number_; });
  if (found != all.end()) return *found;
  Held& added = all.emplace_back();
  added.turns = number_;
  return added;
}

std::uint64_t Turns::next_number() {
  static std::atomic<std::uint64_t> made{0};
  return ++made;
}

// The index of a new turn, which the calling thread holds if `locked`; -1: there are enough.
int Turns::bring(bool locked) {
  while (growing_.exchange(true)) std::this_thread::yield();
  const std::size_t index = count_.load();
  if (index < max_) {
    if (locked) turns_[index].lock();
    count_.store(index + 1);
  }
  growing_.store(false);
  return index < max_ && locked ? static_cast<int>(index) : -1;
}

int Turns::take_any(const std::atomic<bool>* stop) {
  for (std::size_t next = 0;; ++next) {
    const std::size_t count = count_.load();
    for (std::size_t index = 0; index < count; ++index) {
      if (turns_[index].try_lock()) return static_cast<int>(index);
    }
    if (stop != nullptr && stop->load()) return -1;
    if (count == 0) {
      std::this_thread::sleep_for(kNoSpinnerYet);
    } else if (turns_[next % count].try_lock_for(count == 1 ? kLookForStop : kOneOfSeveral)) {
      return static_cast<int>(next % count);
    }
  }
}

void Turns::enter() {
  Held& own = held();
  if (own.index >= 0) {
    // Also a callback that spins, bound or not: others may run meanwhile.
    turns_[static_cast<std::size_t>(own.index)].unlock();
    own.index = -1;
  } else if (!own.brought) {
    own.brought = true;
    bring(false);
  }
}

void Turns::leave() {
  Held& own = held();
  if (own.index >= 0) return;
  if (own.brought || count_.load() == max_) {
    own.index = take_any(nullptr);
  } else {
    // It has begun to spin before there were turns.
    own.brought = true;
    own.index = bring(true);
  }
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
  if (own.index < 0) own.index = take_any(&stop);
  // A thread of a node brings none along, also where its callback spins.
  own.brought = true;
  return own.index >= 0;
}

void Turns::give_back() {
  Held& own = held();
  if (own.index < 0) return;
  turns_[static_cast<std::size_t>(own.index)].unlock();
  own.index = -1;
}

}  // namespace catan_ros
