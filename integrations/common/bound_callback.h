// A callback that is a node: what happens from a trigger to the end of its run, whatever the framework.
//
//   wait for the trigger          (a node that runs by itself: for its message or timer)
//   wait for a message            at most `patience`: the network may be later than the trigger; not at all while the
//                                 program has unsubscribed. None: an empty run, which gives no output, so that the
//                                 server knows that the node lives, and its subchain goes on
//   wait for a newer message      where one lies there and a newer one has been sent: at most `newer_patience`. A
//                                 trigger that comes of a message's sender is quicker than the message
//   take a turn                   of the spinners of the queue that the program asked for (turns.h)
//   begin, call, end              one call, or all that have come where the node's input is a queue; where only the
//                                 newest counts, those before it are made with discarding() set, to be let go of
//   give the turn back            after the end, so that a program which stops spinning has all its runs reported
//
// While the server has let go of the node's subchain, of which another node is missing, there are no runs: the port has
// the framework make the calls, as without Catan, until the subchain is complete.
//
// A run gives output if its thread published anything, or if nothing of the app comes after the node.
//
// Thread safety: run() by the node's thread; note_output() by the thread that is in run(), from within a call;
// let_go_of_older() by any.
#pragma once

#include <catan/awaited.h>

#include <chrono>
#include <functional>
#include <optional>

#include "common/inbox.h"

namespace catan_ros {

// The scheduler's side of a node.
class Schedule {
 public:
  virtual ~Schedule() = default;
  // As ctn::AttachedNode has them.
  virtual ctn::Awaited await() = 0;
  virtual bool await_complete() = 0;
  virtual void begin() = 0;
  virtual void end(bool output) = 0;
};

// Who else is in callbacks of the same queue.
class Turn {
 public:
  virtual ~Turn() = default;
  virtual bool take(const std::atomic<bool>& stop) = 0;
  virtual void give_back() = 0;
};

struct BoundCallbackOptions {
  bool takes_all = false;            // input: queue
  bool takes_newest = false;         // of all that have come, where not takes_all
  bool runs_by_itself = false;       // an unscheduled node with a period
  bool always_gives_output = false;  // what it gives is not published: it goes to the world
  // At most until then it waits for a message that its trigger was for.
  std::chrono::nanoseconds patience = std::chrono::milliseconds{500};
  // ... for a newer message that is under way: between processes of a machine some 0.2 ms.
  std::chrono::nanoseconds newer_patience = std::chrono::milliseconds{2};
};

class BoundCallback {
 public:
  // All references outlive it.
  BoundCallback(const BoundCallbackOptions& options, Inbox& inbox, Turn& turn)
      : options_(options), inbox_(inbox), turn_(turn) {}

  // What is called where no message or timer has come (a timer that a trigger takes the place of); without it, nothing.
  // False: it must not be called at this moment.
  void set_without_message(std::function<bool()> call) { without_message_ = std::move(call); }

  // When the newest message was sent to this node, as far as is known. It is not waited for without that.
  using Time = std::chrono::steady_clock::time_point;
  void set_newest_sent(std::function<std::optional<Time>()> newest_sent) { newest_sent_ = std::move(newest_sent); }

  // What looks for messages that the framework has, and puts them into the inbox: it is called when the trigger has
  // come, so that these need not wait for a thread of the framework's.
  void set_look_for_messages(std::function<void()> look) { look_for_messages_ = std::move(look); }

  // What is called after each run that called something, with the turn given back: who waits for the framework to call
  // something may want to know.
  void set_after_call(std::function<void()> after) { after_call_ = std::move(after); }

  // By the thread that is in run(): from now on each run that calls something gives output.
  void set_always_gives_output() { options_.always_gives_output = true; }

  // What is called by the thread that is in run() when the server has let go of the subchain: from then on the
  // framework is to make the calls. And when it is complete: the second returns when the framework makes none any more.
  void set_let_go(std::function<void()> let_go, std::function<void()> take_back) {
    let_go_ = std::move(let_go);
    take_back_ = std::move(take_back);
  }
  // By the first of these: makes the calls that have come, outside of any run.
  void call_rest();

  // After something was put into the inbox: where only the newest counts, those before it are let go of. So they do not
  // pile up while no trigger comes, and a run need not do it first.
  void let_go_of_older();

  // Until the schedule or the inbox is stopped.
  void run(Schedule& schedule);

  // The run under way gave output, so far.
  void note_output() { output_ = true; }
  // The one whose call the calling thread is in; null: none.
  static BoundCallback* current();
  // The calling thread makes a call whose message is not to reach the program.
  static bool discarding();
  // It does while it has one of these.
  class Discard {
   public:
    Discard();
    ~Discard();
    Discard(const Discard&) = delete;
    Discard& operator=(const Discard&) = delete;
  };

 private:
  bool run_once(Schedule& schedule);
  bool go_without(Schedule& schedule);
  bool wait_for_message();
  void wait_for_newer_message();
  void discard_older();
  bool call_one();
  int call_waiting();

  BoundCallbackOptions options_;
  Inbox& inbox_;
  Turn& turn_;
  std::function<bool()> without_message_;
  std::function<std::optional<Time>()> newest_sent_;
  std::function<void()> look_for_messages_;
  std::function<void()> after_call_;
  std::function<void()> let_go_;
  std::function<void()> take_back_;
  bool output_ = false;
};

}  // namespace catan_ros
