// Relay, a small made-up framework of callbacks, in the place of ROS, ILLIXR and their like: components with one
// callback each, topics between them, timers, an executor with a thread a component. It knows nothing of Catan; all
// that a port needs of a framework is in Hook, which good ones have in one form or another.
//
// A component's callback is called when a message arrives or its timer is due; or, where a hook paces it, when the hook
// says so. Before each call it takes from each subscription the newest message, or all. What it publishes is delivered
// when it returns.
//
// Thread safety: add() and spin() from one thread; stop() from any, and from a signal handler.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace relay {

using Message = std::int64_t;

enum class Keep { kNewest, kAll };

class Call;

struct Subscription {
  std::string topic;
  Keep keep = Keep::kNewest;
};

struct Component {
  std::string name;
  std::vector<Subscription> subscriptions;
  std::string publishes;                           // topic; empty: none
  std::optional<std::chrono::milliseconds> timer;  // none: called when a message arrives
  bool has_helper = false;                         // a second thread, for Call::help()
  std::function<void(Call&)> callback;
};

// When one component runs, and what becomes of it. Used by the component's thread alone.
class Pacing {
 public:
  virtual ~Pacing() = default;
  // Whether wait() says when the component runs; else messages and its timer do.
  virtual bool paces() const = 0;
  // Blocks until the component is to run; false: it is to end.
  virtual bool wait() = 0;
  virtual void begin() = 0;
  // `published`: whether it published anything, which has been delivered.
  virtual void end(bool published) = 0;
};

// What lets others decide when callbacks run.
class Hook {
 public:
  virtual ~Hook() = default;
  // Called by the component's thread when it begins. Null: the component cannot run.
  virtual std::unique_ptr<Pacing> thread_begins(const Component& component) = 0;
  // Called by another thread that works for the component, when it begins.
  virtual void thread_helps(const Component& component) = 0;
};

class Executor {
 public:
  explicit Executor(Hook* hook = nullptr) : hook_(hook) {}
  ~Executor();

  void add(Component component);
  // Runs all components until stop(), and lets callbacks that are under way return.
  void spin();
  void stop() { stopping_.store(true); }
  bool stopping() const { return stopping_.load(); }

 private:
  friend class Call;
  struct Inbox {
    Subscription subscription;
    std::deque<Message> messages;
  };
  struct Actor {
    Component component;
    std::mutex mutex;  // held no longer than it takes to copy messages
    std::condition_variable arrived;
    std::vector<Inbox> inboxes;
    std::thread thread;
    // Work for the helper.
    std::mutex help_mutex;
    std::condition_variable help_changed;
    std::function<void()> help;
    bool helper_ends = false;
    std::thread helper;
  };

  void run(Actor& actor);
  bool wait(Actor& actor, std::chrono::steady_clock::time_point& due);
  bool call(Actor& actor);
  void run_helper(Actor& actor);
  void end_helper(Actor& actor);
  void deliver(const std::string& topic, Message message);

  Hook* hook_;
  std::vector<std::unique_ptr<Actor>> actors_;
  std::atomic<bool> stopping_{false};
};

// One call of a callback.
class Call {
 public:
  // What was taken from a topic for this call, oldest first.
  std::vector<Message> take(const std::string& topic) const;
  void publish(Message message) { published_.push_back(message); }
  // Has the component's helper do something, and waits for it.
  void help(std::function<void()> work);

 private:
  friend class Executor;
  struct Taken {
    std::string topic;
    std::vector<Message> messages;
  };

  explicit Call(Executor::Actor& actor) : actor_(actor) {}

  Executor::Actor& actor_;
  std::vector<Taken> taken_;
  std::vector<Message> published_;
};

}  // namespace relay
