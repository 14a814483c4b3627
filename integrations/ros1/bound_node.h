// A node of the app that is a callback of a ROS program: the callback queue that roscpp is given in place of the
// program's, and the thread in which the node's runs take place.
//
// Several callbacks may be candidates: the one that came first has the node until it is removed, then the next one.
// Those that wait are called from the program's own queue. So `subscriber = handle.subscribe(...)` stays the node,
// though the new subscription comes before the old one goes.
//
// As long as no server schedules the node (none is there, or it refuses, or has let go of the node's subchain),
// callbacks go on to the program's own queue and are called as without Catan. When one does, those that have begun are
// waited for, and those that have not wait for the node's runs: calls of one callback do not overlap.
//
// Thread safety: a candidate's calls from any thread, as roscpp makes them.
#pragma once

#include <ros/callback_queue_interface.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/binding.h"
#include "common/bound_callback.h"
#include "common/inbox.h"
#include "common/kept_messages.h"
#include "common/message_runs.h"
#include "common/node_runs.h"
#include "common/server_connection.h"
#include "common/unbound_calls.h"

namespace catan_ros {

class TurnsOfQueue;

// What the callback is: "a subscription of /scan".
std::string describe(const Binding& binding);

class BoundNode final {
 public:
  class Candidate;

  // `message_runs` is null where there is no such file; `kept` are the program's messages. `connection` outlives it.
  BoundNode(Binding binding, MessageRuns* message_runs, const KeptMessages& kept, ServerConnection& connection);

  const Binding& binding() const { return binding_; }

  // A callback that the program wants to be called from that queue, which outlives it. It is to live as long as roscpp
  // may use the queue that it is, and this node outlives it.
  std::shared_ptr<Candidate> add_candidate(ros::CallbackQueueInterface& original);

  // The program gives that queue up: what was to be called from it is no candidate any more, and a call of it that is
  // under way is waited for.
  void give_up(const ros::CallbackQueueInterface* queue);

  // Begins to register the node, and waits a moment for it, so that no call comes before. Then callbacks may come.
  void start();
  // Its runs end; what comes from now on goes to the program's queue.
  void stop();

  // The one whose run the calling thread is in; null: none.
  static BoundNode* current();
  // By that thread: it is about to publish, or has published, on a topic; it is about to send a message, or to handle
  // one, or has let go of one, with that key.
  void note_sending(const std::string& topic);
  void note_published(const std::string& topic);
  void note_sent(MessageRuns::Key key);
  // It handles a message, of which nothing more need be known.
  void note_message() { has_message_ = true; }
  void note_taken(MessageRuns::Key key);
  void note_let_go(MessageRuns::Key key);

 private:
  class NotingRuns;
  class PassedOn;
  // Of the queue that is the program's at the time when a run begins.
  class CurrentTurn final : public Turn {
   public:
    void set(std::unique_ptr<Turn> turn);
    // Whether no run waits for, or has, another queue's turn.
    bool is_current() const;
    bool take(const std::atomic<bool>& stop) override;
    void give_back() override;

   private:
    mutable PriorityMutex mutex_;
    std::shared_ptr<Turn> next_;
    std::shared_ptr<Turn> held_;  // that of the run; null: none is under way
  };

  void put(Candidate& from, const ros::CallbackInterfacePtr& callback, std::uint64_t id);
  void remove(Candidate& from, std::uint64_t id);
  // To the program's own queue.
  void pass_on(Candidate& from, std::function<Outcome()> call, std::uint64_t id);
  Outcome call_passed_on(const Candidate* from, std::function<Outcome()>& call, std::uint64_t id);
  void join(Candidate& candidate);
  void leave(const Candidate& candidate);
  bool has_node(const Candidate* candidate) const;
  bool is_being_removed(std::uint64_t id) const;
  void give_node_to_first();
  void wake_loop();
  void tell_of_waiting(const Candidate& candidate) const;
  bool call_directly();
  void run();
  void note_begun();
  std::optional<MessageRuns::Time> newest_sent() const;
  // A node that comes next keeps what comes on that topic, though it is bound to another one.
  bool is_taken_by_successor(const std::string& topic) const;
  void tell_of_no_message();
  void bind(bool bound);
  void take_back();

  const Binding binding_;
  MessageRuns* message_runs_;
  const KeptMessages& kept_;
  ServerConnection& connection_;
  NodeRuns* runs_ = nullptr;  // while there are any
  CurrentTurn turn_;
  Inbox inbox_;
  BoundCallback callback_;
  PriorityMutex bound_mutex_;
  std::vector<Candidate*> candidates_;                    // in the order in which they came, under bound_mutex_
  ros::CallbackQueueInterface* queue_of_turn_ = nullptr;  // under bound_mutex_
  std::atomic<TurnsOfQueue*> turns_of_queue_{nullptr};    // of that queue; null: it is not of roscpp's class
  bool bound_ = false;
  std::vector<std::uint64_t> being_removed_;  // under bound_mutex_
  UnboundCalls unbound_;                      // that were passed on
  PriorityCondition settled_changed_;
  bool settled_ = false;  // it is bound, or will not be
  std::atomic<bool> started_{false};
  // Of the node's thread.
  bool has_begun_ = false;
  bool has_message_ = false;
  bool told_of_none_ = false;
  std::chrono::steady_clock::time_point first_run_;
};

// The queue that roscpp is given for one callback.
class BoundNode::Candidate final : public ros::CallbackQueueInterface {
 public:
  Candidate(BoundNode& node, ros::CallbackQueueInterface& original);
  ~Candidate() override;
  Candidate(const Candidate&) = delete;
  Candidate& operator=(const Candidate&) = delete;

  BoundNode& node() { return node_; }

  // Its messages are not let go of before a run: that may be the last who holds the program's object, whose end is not
  // for a thread of roscpp's.
  void keep_all() { keeps_all_.store(true); }

  // A timer's callback, which a trigger may call before the timer is due, and whether the timer runs. False: not at
  // this moment.
  void set_direct_call(std::function<bool()> call, bool timer_runs);

  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t id) override;
  void removeByID(std::uint64_t id) override;

 private:
  friend class BoundNode;

  BoundNode& node_;
  ros::CallbackQueueInterface& original_;
  std::atomic<bool> keeps_all_{false};
  // Under the node's bound_mutex_.
  std::shared_ptr<std::function<bool()>> direct_call_;
  bool timer_runs_ = true;
  bool is_told_of_ = false;
  bool is_given_up_ = false;
};

}  // namespace catan_ros
