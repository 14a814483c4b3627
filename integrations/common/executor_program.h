// The program whose executor calls callbacks that are nodes (executor_callback.h): its connection to the server, and
// which callback is which node, from the environment that `catan ros2 run` makes.
//
// Thread safety: find() by one thread; adopt_this_thread() by any; start() and stop() by one.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/binding.h"
#include "common/executor_callback.h"
#include "common/run_times.h"
#include "common/server_connection.h"

namespace catan_ros {

class ExecutorProgram {
 public:
  // Of this process; null: the environment has no server or no bindings, and all is as without Catan. What is wrong
  // with it is told.
  static std::unique_ptr<ExecutorProgram> from_environment(const ServerConnection::Tell& tell);
  ~ExecutorProgram() { stop(); }
  ExecutorProgram(const ExecutorProgram&) = delete;
  ExecutorProgram& operator=(const ExecutorProgram&) = delete;

  // Looks for a server, and waits a moment for it, so that nothing is called before. There may be one later, too.
  void start();
  // Ends runs and waits; lets callbacks that are under way return.
  void stop();

  // The node that such a callback of that ROS node is; null: it is none. Of a timer the period is asked for.
  ExecutorCallback* find(const std::string& ros_node, Binding::Kind kind, const std::string& name,
                         std::chrono::nanoseconds period = std::chrono::nanoseconds{0});
  void adopt_this_thread(const std::string& node) { connection_.adopt_this_thread(node); }
  // It works for all nodes of this program.
  void share_thread(int thread) { connection_.share_thread(thread); }
  void tell(ServerConnection::Severity severity, const std::string& text) const { tell_(severity, text); }

 private:
  ExecutorProgram(const std::vector<Binding>& bindings, std::unique_ptr<RunTimes> run_times,
                  ServerConnection::Tell tell);

  const ServerConnection::Tell tell_;
  const std::unique_ptr<RunTimes> run_times_;
  ServerConnection connection_;
  std::atomic<bool> stopped_{false};
  std::thread connecting_;
  std::deque<ExecutorCallback> callbacks_;
};

}  // namespace catan_ros
