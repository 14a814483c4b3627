// The callback queues of nodelets: whose they are, and whose turn it is to call back from them.
//
// A nodelet has two queues of its manager's: one whose callbacks the manager's threads (its workers) call one at a
// time, and one whose callbacks they call side by side. So a callback is of the nodelet of whose queue it is; that is
// what tells apart those of nodelets that take one topic. A queue of the first kind has one turn (turns.h), which a
// worker holds while it calls, and which the thread of a bound callback takes as well: so nothing of a nodelet overlaps
// that did not before, and a bound callback waits for no worker. A queue of the second kind needs none.
//
// A queue is known by where it lies. Another may come to lie there when it is gone: what is said of an address is of
// the queue that is there now, but for the turn, which stays the same.
//
// Thread safety: all calls from any thread; call() and called() by one thread each, without a lock.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

#include "common/bound_callback.h"
#include "common/turns.h"

namespace catan_ros {

class NodeletQueues {
 public:
  // Addresses. Of queues at more than these nothing is known.
  static constexpr std::size_t kMaxQueues = 512;

  NodeletQueues() = default;
  ~NodeletQueues();
  NodeletQueues(const NodeletQueues&) = delete;
  NodeletQueues& operator=(const NodeletQueues&) = delete;

  // A queue comes to be, before anything is put into it; it goes, with all that was in it.
  void add(const void* queue, bool one_at_a_time);
  void remove(const void* queue);
  // It is that nodelet's. Without add() before, nothing is known of how it is called.
  void set_nodelet(const void* queue, const std::string& nodelet);

  // Empty: none's that is known.
  std::string nodelet_of(const void* queue) const;
  bool calls_one_at_a_time(const void* queue) const;

  // A worker calls a callback of the queue, and has done so; `taken` is what call() returned: null where no turn is
  // needed, or nothing is known of the queue.
  void* call(const void* queue);
  static void called(void* taken);
  // For a bound callback of the queue. Null: nothing is known of how that calls. It is as good as this object.
  std::unique_ptr<Turn> turn_of(const void* queue);

 private:
  enum class Calls { kUnknown, kOneAtATime, kSideBySide, kGone };
  struct Queue {
    explicit Queue(const void* where) : address(where) {}
    const void* const address;
    std::atomic<Calls> calls{Calls::kUnknown};
    Turns turns{1};
    std::string nodelet;  // under the mutex
  };
  class DirectTurn;

  Queue* find(const void* queue) const;
  Queue* find_or_add(const void* queue);

  mutable std::mutex mutex_;
  // Written under the mutex, at the end only.
  std::array<std::atomic<Queue*>, kMaxQueues> queues_{};
  std::atomic<std::size_t> count_{0};
};

}  // namespace catan_ros
