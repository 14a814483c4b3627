// Who may run callbacks of one callback queue at this moment. Without Catan these are the threads that spin the queue:
// one has one callback at a time, and none while it does something else of the program's. With Catan, bound callbacks
// run in threads of their own nodes; so that nothing overlaps that did not before, each takes one of the spinners'
// turns.
//
// Each spinner brings one turn along. It gives it up when it begins to spin and takes one, any, when it has done so and
// before each callback that is not bound. So a queue with one spinner has one callback at a time, and the program's own
// code between two calls of spinOnce() is never disturbed; one with four has four. A callback that waits for its
// trigger holds no turn, so it holds up no other.
//
// A turn is a mutex with priority inheritance: a spinner at the ordinary level that has one is raised to the level of
// the node that waits for it. Where there is more than one turn, a thread that finds none free tries them in turn, a
// millisecond each, since it cannot wait for several: it is at most so much later.
//
// A queue that itself keeps its callbacks apart, whoever calls them (a nodelet's), has one turn from the beginning, and
// nobody brings another.
//
// Thread safety: all calls from any thread; begin/end, enter/leave, take/give_back by one thread each.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "common/priority_mutex.h"

namespace catan_ros {

class Turns {
 public:
  static constexpr std::size_t kMaxSpinners = 64;  // more bring no turn along

  Turns() = default;
  // So many from the beginning, kMaxSpinners at most; spinners bring none.
  explicit Turns(std::size_t count) : max_(count), count_(count) {}

  // --- by a thread that spins the queue ---
  // It begins to wait for callbacks, and does so no longer.
  void enter();
  void leave();
  // It calls a callback that is not bound, and has done so; `taken` is what begin() returned.
  bool begin();
  void end(bool taken);

  // --- by a node's thread ---
  // False: `stop` became true. A queue that no thread has spun yet has no turn.
  bool take(const std::atomic<bool>& stop);
  void give_back();

 private:
  // Of the calling thread, in this queue.
  struct Held {
    std::uint64_t turns = 0;  // their number
    int index = -1;           // of the turn that it holds; -1: none
    bool brought = false;     // its own along
  };
  Held& held() const;
  static std::uint64_t next_number();
  int bring(bool locked);
  int take_any(const std::atomic<bool>* stop);

  const std::uint64_t number_ = next_number();  // another may get its address after it
  const std::size_t max_ = kMaxSpinners;
  std::array<PriorityMutex, kMaxSpinners> turns_;
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> growing_{false};
};

}  // namespace catan_ros
