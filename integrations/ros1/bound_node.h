// A node of the app that is a callback of a ROS program: the callback queue that roscpp is given in place of the
// program's, and the thread in which the node's runs take place.
//
// As long as no server schedules the node (none is there, or it refuses), callbacks go on to the program's own queue
// and are called as without Catan.
//
// Thread safety: addCallback and removeByID from any thread, as roscpp calls them; what configures it before start().
#pragma once

#include <ros/callback_queue_interface.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "common/binding.h"
#include "common/bound_callback.h"
#include "common/inbox.h"
#include "common/kept_messages.h"
#include "common/message_runs.h"
#include "common/node_runs.h"
#include "common/server_connection.h"

namespace catan_ros {

class BoundNode final : public ros::CallbackQueueInterface {
 public:
  // `original` is the program's queue, which outlives the callbacks; one of them has the node.
  // `message_runs` is null where there is no such file; `kept` are the program's messages. `connection` outlives it.
  BoundNode(Binding binding, ros::CallbackQueueInterface& original, MessageRuns* message_runs, const KeptMessages& kept,
            ServerConnection& connection);

  const Binding& binding() const { return binding_; }

  // A callback that the program wants to be called from that queue takes the node; removeByID() gives it back. False:
  // another one has it.
  bool take(ros::CallbackQueueInterface& queue);

  // A timer's callback, which a trigger may call before the timer is due. False: not at this moment.
  void set_direct_call(std::function<bool()> call);
  // Of a timer: whether it runs, so that a trigger may call it.
  bool timer_runs() const { return timer_runs_.load(); }
  void set_timer_runs(bool runs) { timer_runs_.store(runs); }

  // Begins to register the node, and waits a moment for it, so that no call comes before. Then callbacks may come.
  void start();
  // Its runs end; what comes from now on goes to the program's queue.
  void stop();

  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t id) override;
  void removeByID(std::uint64_t id) override;

  // The one whose run the calling thread is in; null: none.
  static BoundNode* current();
  // By that thread: it is about to publish, or has published, on a topic; it is about to send a message, or to handle
  // one, or has let go of one, with that key.
  void note_sending(const std::string& topic);
  void note_published(const std::string& topic);
  void note_sent(MessageRuns::Key key);
  void note_taken(MessageRuns::Key key);
  void note_let_go(MessageRuns::Key key);

 private:
  class NotingRuns;
  // Of the queue that is the program's at the time.
  class CurrentTurn final : public Turn {
   public:
    void set(std::unique_ptr<Turn> turn);
    bool take(const std::atomic<bool>& stop) override;
    void give_back() override { held_->give_back(); }

   private:
    PriorityMutex mutex_;
    std::shared_ptr<Turn> next_;
    std::shared_ptr<Turn> held_;  // by the node's thread
  };

  bool call_directly();
  void run();
  void note_begun();
  std::optional<MessageRuns::Time> newest_sent() const;
  // A node that comes next keeps what comes on that topic, though it is bound to another one.
  bool is_taken_by_successor(const std::string& topic) const;
  void tell_of_no_message();
  void bind(bool bound);

  const Binding binding_;
  std::atomic<ros::CallbackQueueInterface*> original_;  // changed under bound_mutex_
  MessageRuns* message_runs_;
  const KeptMessages& kept_;
  ServerConnection& connection_;
  NodeRuns* runs_ = nullptr;  // while there are any
  CurrentTurn turn_;
  Inbox inbox_;
  BoundCallback callback_;
  PriorityMutex bound_mutex_;
  bool bound_ = false;
  PriorityCondition settled_changed_;
  bool settled_ = false;  // it is bound, or will not be
  std::atomic<bool> timer_runs_{true};
  std::atomic<bool> taken_{true};
  std::shared_ptr<std::function<bool()>> direct_call_;  // under bound_mutex_
  bool started_ = false;
  // Of the node's thread.
  bool has_begun_ = false;
  bool has_message_ = false;
  bool told_of_none_ = false;
  std::chrono::steady_clock::time_point first_run_;
};

}  // namespace catan_ros
