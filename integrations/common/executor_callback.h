// A callback that is a node, of a framework whose callbacks are called by executors (ROS 2): what its executor has for
// it waits here until the node's trigger comes, and is called in the node's own thread.
//
//   collect()          takes what the framework has for it: by the executor, when that says there is something, and by
//                      the node's thread, when its trigger has come. So who is triggered by a node of the same program,
//                      or by one whose message is there already, waits for no other thread
//   exclusion          of callbacks that may not run at the same time (a callback group): a mutex with priority
//                      inheritance, which is held for the run; waiting for a trigger holds none
//   lineage            a message's sender is the run of a predecessor within which it was sent (run_times.h)
//
// As long as no server schedules the node, or has let go of its subchain, bound() is false and the executor calls the
// callback itself.
//
// Thread safety: bound(), collect(), offer() and connect() from any thread; start() and stop() by one;
// note_published() by the thread that is in a run.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "common/bound_callback.h"
#include "common/inbox.h"
#include "common/local_node.h"
#include "common/priority_mutex.h"
#include "common/run_times.h"

namespace catan_ros {

class ExecutorCallback final : public LocalNode {
 public:
  // Makes the calling thread the node's, however long that takes; null: it will not be, or `stop` became true.
  // `settled` is called as soon as that is known, or may take long.
  using Attach =
      std::function<std::unique_ptr<Runs>(const std::atomic<bool>& stop, const std::function<void()>& settled)>;

  struct Call {
    std::int64_t sent = 0;       // when, in ns since the epoch; 0: not known
    std::function<bool()> call;  // false: who is to be called is gone
  };
  // What to call, and when.
  struct Callback {
    std::function<std::optional<Call>()> take;  // the framework's next message; empty: only the executor has them
    std::function<bool()> direct;               // a timer's, which a trigger calls whether it is due or not; else empty
    PriorityMutex* exclusion = nullptr;         // outlives this; null: it may be called at any time
    // Gets what a call throws, which is to come out of the executor; the run goes on to its end. Empty: it ends the
    // program, as what a thread throws.
    std::function<void(std::exception_ptr)> thrown = {};
  };

  // `run_times` outlives it.
  ExecutorCallback(Binding binding, RunTimes& run_times, Attach attach);
  ~ExecutorCallback() override { stop(); }

  // Another one takes the place of the callback that was: the program has let go of that.
  void connect(Callback callback);
  // Begins to register the node, and waits a moment for that, so that no call comes before.
  void start();
  // Lets the run that is under way return, and begins no other.
  void stop();

  bool bound() const { return bound_.load(); }
  void collect();
  // False: no server schedules the node any more, and the executor is to make the call.
  bool offer(Call call);

  void note_published(const std::string& topic) override;
  // Each run gives output: what it publishes is not seen.
  void set_always_gives_output() { always_gives_output_.store(true); }

 private:
  class NotingRuns;
  class GroupTurn;

  void run();
  void set_bound(bool bound);
  void let_go(BoundCallback& callback, Turn& turn);
  bool call_directly();
  void put(Call call);
  bool call_handing_on_exceptions(const std::function<bool()>& call);
  void hand_on(const std::exception_ptr& exception);

  RunTimes& run_times_;
  const Attach attach_;
  Inbox inbox_;
  PriorityMutex mutex_;  // of callback_; held while messages are taken, so that they stay in order
  Callback callback_;
  PriorityMutex settled_mutex_;
  PriorityCondition settled_changed_;
  bool settled_ = false;
  std::atomic<bool> bound_{false};
  std::atomic<bool> always_gives_output_{false};
  std::thread thread_;
};

}  // namespace catan_ros
