// The turns of each of roscpp's queues that has bound callbacks (common/turns.h), and how a node's thread gets one of a
// queue, whatever its class.
//
// Thread safety: turns_of() and find_turns() from any thread, the latter without a lock; a QueueTurn or LentTurn by the
// node's thread.
#pragma once

#include <ros/callback_queue.h>

#include <atomic>
#include <memory>

#include "common/bound_callback.h"
#include "common/nodelet_queues.h"
#include "common/turns.h"

namespace catan_ros {

// Made at the first call for a queue, and never let go. Null: there are too many.
Turns* turns_of(const ros::CallbackQueue* queue);
Turns* find_turns(const ros::CallbackQueue* queue);
const std::atomic<bool>& has_turns();

// Of this program; never let go.
NodeletQueues& nodelet_queues();

// Of a queue of roscpp's own class, whose spinners are seen by the hooks.
class QueueTurn final : public Turn {
 public:
  explicit QueueTurn(Turns& turns) : turns_(turns) {}
  bool take(const std::atomic<bool>& stop) override { return turns_.take(stop); }
  void give_back() override { turns_.give_back(); }

 private:
  Turns& turns_;
};

// Of any other queue than roscpp's and nodelets': a callback is put into it, and who calls that waits until the node's
// run has ended. So whatever keeps callbacks of that queue apart keeps the node apart, too. It takes two more changes
// of thread, and the run begins when that other thread has got a CPU.
class LentTurn final : public Turn {
 public:
  explicit LentTurn(ros::CallbackQueueInterface& queue) : queue_(queue) {}
  bool take(const std::atomic<bool>& stop) override;
  void give_back() override;

 private:
  class Loan;

  ros::CallbackQueueInterface& queue_;
  std::shared_ptr<Loan> loan_;
};

std::unique_ptr<Turn> make_turn(ros::CallbackQueueInterface& queue);

}  // namespace catan_ros
