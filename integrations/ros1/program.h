// The program that the port is loaded into: its bindings, its connection to the server, its nodes.
//
// Never let go, since threads of the program may use it until the process is gone.
//
// Thread safety: all calls from any thread.
#pragma once

#include <ros/callback_queue_interface.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/asked_callbacks.h"
#include "common/binding.h"
#include "common/kept_messages.h"
#include "common/message_runs.h"
#include "common/server_connection.h"
#include "ros1/bound_node.h"

namespace catan_ros {

class Program {
 public:
  // `messages_file`: that message_runs.h is about; empty: there is none. Where it cannot be had, the program's log says
  // so, and it goes on without.
  Program(std::vector<Binding> bindings, std::string messages_file);

  using CandidatePtr = std::shared_ptr<BoundNode::Candidate>;

  // A callback of this program, which is to be called from that queue, as the node that it may be; null: no binding
  // names it. Where the binding names a nodelet, those of others are not meant.
  CandidatePtr find(Binding::Kind kind, const std::string& name, ros::CallbackQueueInterface& queue);
  CandidatePtr find_timer(std::chrono::nanoseconds period, ros::CallbackQueueInterface& queue);

  // Whether runs of this program's nodes have predecessors, so that it matters which messages it gets.
  bool notes_messages();
  // It subscribes that topic, with that queue: those that send on it are told that its nodes may take it, of a nodelet
  // those that are the same nodelet's.
  void note_subscription(const std::string& topic, const ros::CallbackQueueInterface& queue);
  // It gives that queue up, and goes on when no node is in a callback of it.
  void give_up(const ros::CallbackQueueInterface* queue);
  // Some callback of this program is to be a node.
  bool is_bound();
  KeptMessages& kept() { return kept_; }

  // The calling thread works for the node. Where that is refused, it stays as it is.
  void adopt_this_thread(const std::string& node) { connection_.adopt_this_thread(node); }
  // It works for all nodes of this program.
  void share_thread(int thread) { connection_.share_thread(thread); }

  void stop();

 private:
  const std::vector<Binding>& bindings();
  CandidatePtr find(const Binding* binding, ros::CallbackQueueInterface& queue);
  void tell_missing();

  const std::vector<Binding> all_bindings_;
  const std::string messages_file_;
  const std::unique_ptr<MessageRuns> message_runs_;  // null: none
  KeptMessages kept_;
  std::mutex mutex_;
  std::optional<std::vector<Binding>> bindings_;  // of this ROS node
  AskedCallbacks asked_;                          // under mutex_, until all that is missing was told
  ServerConnection connection_;
  std::deque<std::unique_ptr<BoundNode>> nodes_;  // of each binding one at most
  std::atomic<bool> stopped_{false};              // becomes true under mutex_
  std::condition_variable changed_;               // of stopped_ and nodes_
};

}  // namespace catan_ros
