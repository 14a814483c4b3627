#include "runtime/node_threads.h"

#include <algorithm>

namespace ctn::runtime {

std::vector<std::pair<NodeId, os::ThreadId>> NodeThreads::spawn() {
  const std::size_t nodes = app_.graph.nodes().size();
  numbers_ = std::vector<std::atomic<std::int32_t>>(nodes);
  for (std::size_t index = 0; index < nodes; ++index) {
    const NodeId node(index);
    if (!wiring_.body(node)) continue;
    threads_.push_back(os_.spawn(app_.graph.node(node).name, [this, node] {
      numbers_[node.index()].store(static_cast<std::int32_t>(os_.current_thread()), std::memory_order_relaxed);
      ready_.fetch_add(1, std::memory_order_release);
      os_.wake(ready_);
      while (go_.load(std::memory_order_acquire) == 0) os_.wait(go_, 0, kNever);
      run(node);
      numbers_[node.index()].store(0, std::memory_order_release);
      ended_count_.fetch_add(1, std::memory_order_release);
      os_.wake(ended_count_);
    }));
  }
  await_ready();
  std::vector<std::pair<NodeId, os::ThreadId>> threads;
  for (std::size_t index = 0; index < nodes; ++index) {
    const std::int32_t number = numbers_[index].load(std::memory_order_relaxed);
    if (number != 0) threads.emplace_back(NodeId(index), os::ThreadId{number});
  }
  return threads;
}

// From then on it is known which number each has.
void NodeThreads::await_ready() {
  for (std::uint32_t ready = 0; ready < threads_.size();) {
    os_.wait(ready_, ready, kNever);
    ready = ready_.load(std::memory_order_acquire);
  }
}

void NodeThreads::go() {
  go_.store(1, std::memory_order_release);
  os_.wake(go_);
}

void NodeThreads::request_stop() {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    const bool ended = !numbers_.empty() && numbers_[index].load(std::memory_order_acquire) == 0;
    if (wiring_.body(NodeId(index)) && !ended) wiring_.port(NodeId(index))->stop();
  }
}

// What a node waits on may be written by others at any time, also so that it does not see that it was to stop: it is
// told until it has.
void NodeThreads::stop() {
  constexpr Nanos kAgain = std::chrono::milliseconds{20};
  await_ready();
  request_stop();
  go();
  for (;;) {
    const std::uint32_t ended = ended_count_.load(std::memory_order_acquire);
    if (ended >= threads_.size()) break;
    if (os_.wait(ended_count_, ended, os_.now() + kAgain) == os::WaitResult::kTimedOut) request_stop();
  }
  for (const auto& thread : threads_) thread->join();
  threads_.clear();
}

bool NodeThreads::is_current() const {
  const auto current = static_cast<std::int32_t>(os_.current_thread());
  return std::any_of(numbers_.begin(), numbers_.end(),
                     [&](const auto& number) { return number.load(std::memory_order_relaxed) == current; });
}

void NodeThreads::run(NodeId node) {
  const graph::Node& described = app_.graph.node(node);
  if (described.unscheduled && !described.follows) {
    run_by_timer(node, *described.period);
  } else {
    run_when_triggered(node);
  }
}

void NodeThreads::run_when_triggered(NodeId node) {
  NodePort& port = *wiring_.port(node);
  const NodeBody& body = wiring_.body(node);
  Run run;
  while (port.wait_for_trigger()) {
    port.begin(run);
    body(run);
    port.end(run);
  }
}

void NodeThreads::run_by_timer(NodeId node, Nanos period) {
  NodePort& port = *wiring_.port(node);
  const NodeBody& body = wiring_.body(node);
  Run run;
  for (TimePoint next = os_.now() + period; port.wait_until(next); next = std::max(next + period, os_.now())) {
    port.begin(run);
    body(run);
    port.end(run);
  }
}

}  // namespace ctn::runtime
