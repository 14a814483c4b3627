// A program's connection to the server that CATAN_SOCKET names, for ports whose threads become nodes: it is made when
// there is a server, and nodes are registered as soon as it takes them.
//
// That there is no server at a moment is no mistake. Where it refuses a node, another program runs it, which may be
// about to end: one of the same name that this one takes the place of.
//
// Thread safety: all calls from any thread.
#pragma once

#include <catan/client.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace catan_ros {

class ServerConnection {
 public:
  // Between two tries: to find a server or to register a node, and where the server has refused the node.
  static constexpr std::chrono::milliseconds kTryAgain{100};
  static constexpr std::chrono::seconds kTryAgainWhenRefused{1};

  enum class Severity { kWarning, kError };
  using Tell = std::function<void(Severity severity, const std::string& text)>;

  // `tell` writes into the program's log, from any thread.
  explicit ServerConnection(Tell tell) : tell_(std::move(tell)) {}

  // Waits for a server that schedules the app; null: `stop` became true, or no server ever will.
  ctn::Client* client(const std::atomic<bool>& stop);

  // Whether there has been a server.
  bool connected() const { return there_.load(); }

  // What a node has been told of its registration so far.
  struct Tries {
    bool refused = false;
  };
  // Makes the calling thread the node's, where there has been a server. None: not at this moment; it may be tried again
  // after kTryAgain, or kTryAgainWhenRefused.
  std::optional<ctn::AttachedNode> try_attach(const std::string& node, Tries& tries);
  // Tries until it is the node's. `on_refused` is called once. None: `stop` became true, or no server ever will.
  std::optional<ctn::AttachedNode> attach(const std::string& node, const std::atomic<bool>& stop,
                                          const std::function<void()>& on_refused);

  // The calling thread works for the node. Where that is refused, it stays as it is.
  void adopt_this_thread(const std::string& node);

  // A thread of this program works for all of its nodes: told to the server as soon as there is one. Does not wait.
  void share_thread(int thread);

  // Ends the nodes' waits; no node is registered from now on.
  void stop();

 private:
  void tell_shared();

  const Tell tell_;
  std::mutex mutex_;  // no node is registered while the client stops
  std::optional<ctn::Client> client_;
  std::atomic<bool> there_{false};  // client_ is
  bool refused_ = false;
  std::atomic<bool> stopped_{false};
  std::mutex shared_mutex_;
  std::vector<int> shared_;  // threads that the client has not been told of
};

}  // namespace catan_ros
