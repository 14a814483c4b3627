// A callback that is a node, in a program whose nodes share messages: its runs take place in a thread of its own.
//
// A message comes to it in two ways: from the thread that publishes it, at once, which is no slower than the trigger;
// and from the framework, whose thread may be kept from running for a while. Whichever comes second is dropped. What is
// published by someone who does not know of this comes from the framework alone.
//
// A run that finds no message is empty, and gives no output.
//
// As long as the node is not registered (no server is there, or it refuses), the framework's thread calls. What is on
// its way to that thread when the node is registered is for the node's runs, and comes before what is published then.
// So it is while the server has let go of the node's subchain.
//
// Thread safety: start() and stop() from one thread; the rest from any.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/bound_callback.h"
#include "common/inbox.h"
#include "common/local_hooks.h"
#include "common/local_node.h"
#include "common/priority_mutex.h"
#include "common/unbound_calls.h"

namespace catan_ros {

class LocalCallback final : public LocalNode, public CallbackHook {
 public:
  using Message = std::shared_ptr<const void>;
  using Call = std::function<void(const Message&)>;
  // Makes the calling thread the node's, however long that takes; null: it will not be, or `stop` became true.
  using Attach = std::function<std::unique_ptr<Runs>(const std::atomic<bool>& stop)>;

  LocalCallback(Binding binding, MessageRuns& message_runs, Attach attach, Call call);
  ~LocalCallback() override { stop(); }

  void start();
  // Ends its runs: lets the one that is under way return. What comes from now on is not called.
  void stop();

  // By the thread that publishes: before it gives a message to the framework, and after.
  void expect(const void* message);
  void deliver(const Message& message);
  void arrived(const Message& message) override;

  void note_published(const std::string& topic) override;

 private:
  class OneAtATime;
  class NotingRuns;
  // A message that was not yet seen both ways.
  struct Sent {
    const void* address;
    Message kept;            // for when the node is registered, if that is before the framework's thread brings it
    bool delivered = false;  // by the thread that publishes
    bool arrived = false;    // by the framework's
    bool handled = false;    // it was put into the inbox, or is called by the framework's thread
  };

  void run();
  void bind();
  void let_go(BoundCallback& callback, Turn& turn);
  // By the framework's thread. Whether the message is for the node's runs, or was called; else that thread is to call.
  bool arrive_at_node(const Message& message);
  void put(const Message& message);
  Inbox::Entry entry_of(const Message& message);
  std::vector<Sent>::iterator find(const void* address);

  const Attach attach_;
  const Call call_;
  Inbox inbox_;
  PriorityMutex calling_;  // held while the program's code runs
  PriorityMutex mutex_;
  bool bound_ = false;
  UnboundCalls unbound_;
  std::vector<Sent> sent_;  // in the order in which they were published
  std::thread thread_;
};

}  // namespace catan_ros
