// The threads that call the nodes' functions: one a node. A scheduled node's is woken by its triggers, an unscheduled
// one's every period, or by the outputs of the node that it follows.
//
// Thread safety: one owner; is_current() and request_stop() from any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "graph/app.h"
#include "os/os.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

class NodeThreads {
 public:
  // All outlive it.
  NodeThreads(const graph::App& app, os::Os& os, Wiring& wiring) : app_(app), os_(os), wiring_(wiring) {}
  ~NodeThreads() { stop(); }
  NodeThreads(const NodeThreads&) = delete;
  NodeThreads& operator=(const NodeThreads&) = delete;

  // Makes a thread for each node that has a function; they wait for go(). Returns which is whose. Throws as
  // Threads::spawn() does; then those that were made are there, and stop() ends them.
  std::vector<std::pair<NodeId, os::ThreadId>> spawn();
  void go();
  // Lets runs that are under way end, and joins. Before go() no run begins any more.
  void stop();
  // No run begins any more. From any thread, from spawn() on.
  void request_stop();
  // Whether the calling thread is one of them.
  bool is_current() const;

 private:
  void await_ready();
  void run(NodeId node);
  void run_when_triggered(NodeId node);
  void run_by_timer(NodeId node, Nanos period);

  const graph::App& app_;
  os::Os& os_;
  Wiring& wiring_;
  std::vector<std::atomic<std::int32_t>> numbers_;  // by node: its thread; 0: none, or ended. Empty before spawn()
  std::atomic<std::uint32_t> ready_{0};
  std::atomic<std::uint32_t> go_{0};
  std::atomic<std::uint32_t> ended_count_{0};
  std::vector<std::unique_ptr<os::Thread>> threads_;
};

}  // namespace ctn::runtime
