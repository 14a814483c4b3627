// The turns of each of roscpp's queues that has bound callbacks (common/turns.h), and how a node's thread gets one of a
// queue, whatever its class.
//
// A program may have a loop of its own, which works on what callbacks have stored:
//   while (ros::ok()) { queue.callAvailable(ros::WallDuration(1.0)); work(); }
// Without Catan a message ends that wait. A bound callback is called in its node's thread, so something else has to.
//
// Thread safety: turns_of(), find_turns() and a TurnsOfQueue from any thread, find_turns() without a lock; a QueueTurn
// or LentTurn by the node's thread.
#pragma once

#include <ros/callback_queue.h>

#include <atomic>
#include <memory>

#include "common/bound_callback.h"
#include "common/nodelet_queues.h"
#include "common/turns.h"

namespace catan_ros {

class TurnsOfQueue final : public Turns {
 public:
  // By a loop of the program's own: before it waits in the queue, and when it does so no longer.
  void begin_loop() { loops_.fetch_add(1); }
  void end_loop() { loops_.fetch_sub(1); }

  // By a node, after a run of this queue: the loop that waits goes on, if there is one. Precondition: `queue` lives.
  void wake_loop(ros::CallbackQueueInterface& queue);
  bool has_waiting_loop() const { return loops_.load() > 0; }

 private:
  class WakeUp;

  std::atomic<int> loops_{0};
  std::atomic<bool> is_woken_{false};
};

// Made at the first call for a queue, and never let go. Null: there are too many.
TurnsOfQueue* turns_of(const ros::CallbackQueue* queue);
TurnsOfQueue* find_turns(const ros::CallbackQueue* queue);
// Of a queue of roscpp's own class; null: it is of another, or there are too many.
TurnsOfQueue* turns_of(ros::CallbackQueueInterface& queue);
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
