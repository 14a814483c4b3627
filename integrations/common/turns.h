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
// A spinner that ends takes one turn along, so as many are left as there are spinners.
//
// A queue that itself keeps its callbacks apart, whoever calls them (a nodelet's), has one turn from the beginning, and
// nobody brings another.
//
// Thread safety: all calls from any thread; begin/end, enter/leave, take/give_back by one thread each.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

namespace catan_ros {

class Turns {
 public:
  static constexpr std::size_t kMaxSpinners = 64;  // at a time; more bring no turn along

  Turns();
  // So many from the beginning, kMaxSpinners at most; spinners bring none.
  explicit Turns(std::size_t count);

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
  // All the turns; as good as this object and each thread that has used it.
  class Slots;
  // Of the calling thread, in this queue.
  struct Held;
  class HeldByThread;
  Held& held() const;
  void bring(Held& own);

  const std::shared_ptr<Slots> slots_;
};

}  // namespace catan_ros
