// What a port of a framework must do, in words that every framework has. The suite (suite_test.cpp) describes small
// apps by these and runs them through a Port; each port implements it, and passes the suite.
//
// Thread safety: a Port is used by one thread. Callbacks are called as the framework calls them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ctn::conformance {

// One call of a node's callback.
class Call {
 public:
  virtual ~Call() = default;
  // The messages of a predecessor in the same program that this call is to handle, oldest first.
  virtual std::vector<std::int64_t> take(const std::string& from) = 0;
  // A call that publishes nothing gives no output.
  virtual void publish(std::int64_t message) = 0;
  // Does something in another thread, which the framework has for this node (a worker of its pool), and waits for it.
  virtual void on_another_thread(const std::function<void()>& work) = 0;
};

struct Node {
  struct Input {
    std::string from;
    bool queue = false;  // all messages since the call before; else the newest
  };

  std::string name;  // of the app file
  std::vector<Input> inputs;
  bool publishes = true;
  std::optional<std::chrono::milliseconds> timer;  // the framework's own runs it: an unscheduled node
  bool has_another_thread = false;                 // its callback calls on_another_thread()
  std::function<void(Call&)> callback;
};

class Port {
 public:
  virtual ~Port() = default;
  // Runs these nodes in this process as the framework does, scheduled by the server that CATAN_SOCKET names, until
  // `stop` is true. Called in a process that has no other thread, at most once. Returns the exit code of the process: 0
  // where all nodes could be registered, and callbacks under way have returned.
  virtual int run(const std::vector<Node>& nodes, const std::atomic<bool>& stop) = 0;
};

// An entry of INSTANTIATE_TEST_SUITE_P.
struct PortUnderTest {
  const char* name;
  std::unique_ptr<Port> (*make)();
};

}  // namespace ctn::conformance
