#include "runtime/node_link.h"

#include <algorithm>

namespace ctn::runtime {

NodeLink::NodeLink(os::Os& os, const graph::Graph& graph, NodeId node, const Region& region)
    : os_(os),
      node_(node),
      predecessors_(graph.node(node).predecessors),
      cell_(region.node(node)),
      reports_(region.reports_reader(node)) {}

bool NodeLink::add_thread(os::ThreadId thread) {
  Result<std::unique_ptr<os::CpuClock>> clock = os_.cpu_clock(thread);
  const std::lock_guard lock(mutex_);
  for (std::size_t index = 0; index < threads_.size(); ++index) {
    if (threads_[index].load(std::memory_order_relaxed) != 0 || leaving_[index]) continue;
    if (clock) clocks_[index] = *std::move(clock);
    threads_[index].store(static_cast<std::int32_t>(thread), std::memory_order_seq_cst);
    publish_threads();
    joined_.fetch_add(1, std::memory_order_release);
    return true;
  }
  return false;
}

void NodeLink::remove_thread(os::ThreadId thread) {
  remove_if([&](std::int32_t each) { return each == static_cast<std::int32_t>(thread); });
}

void NodeLink::remove_all_threads() {
  remove_if([](std::int32_t) { return true; });
}

template <class IsMeant>
void NodeLink::remove_if(const IsMeant& is_meant) {
  std::array<bool, NodeCell::kMaxThreads> removed{};
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t index = 0; index < threads_.size(); ++index) {
      const std::int32_t thread = threads_[index].load(std::memory_order_relaxed);
      removed[index] = thread != 0 && is_meant(thread);
      if (!removed[index]) continue;
      leaving_[index] = true;
      threads_[index].store(0, std::memory_order_seq_cst);
    }
    publish_threads();
  }
  wait_for_visitors();
  const std::lock_guard lock(mutex_);
  for (std::size_t index = 0; index < threads_.size(); ++index) {
    if (!removed[index]) continue;
    clocks_[index].reset();
    leaving_[index] = false;
  }
}

// Visits are a few system calls long, of threads that outrank us; visits that begin now do not see the thread any more.
void NodeLink::wait_for_visitors() const {
  constexpr Nanos kPause = std::chrono::microseconds{50};
  while (visitors_.load(std::memory_order_seq_cst) != 0) os_.sleep_until(os_.now() + kPause);
}

// Also for the node, which adds up what its threads used.
void NodeLink::publish_threads() {
  std::size_t count = 0;
  for (std::size_t index = 0; index < threads_.size(); ++index) {
    const std::int32_t thread = threads_[index].load(std::memory_order_relaxed);
    cell_.thread[index].store(thread, std::memory_order_release);
    if (thread != 0) count = index + 1;
  }
  used_.store(count, std::memory_order_release);
  cell_.threads.store(static_cast<std::uint32_t>(count), std::memory_order_release);
}

std::vector<os::ThreadId> NodeLink::threads() const {
  std::vector<os::ThreadId> threads;
  for_each_thread([&](os::ThreadId thread) { threads.push_back(thread); });
  return threads;
}

bool NodeLink::has(os::ThreadId thread) const {
  return std::find(threads_.begin(), threads_.end(), static_cast<std::int32_t>(thread)) != threads_.end();
}

void NodeLink::trigger(std::uint64_t token) {
  cell_.word.store(static_cast<std::uint32_t>(token), std::memory_order_release);
  os_.wake(cell_.word);
}

bool NodeLink::is_triggered(std::uint64_t token) const {
  return cell_.word.load(std::memory_order_acquire) == static_cast<std::uint32_t>(token);
}

// The order of the two reads matters: a program that triggers the run itself writes the token before the run can end.
void SubchainLinks::trigger(std::uint64_t number) const {
  NodeLink& head = *nodes.front();
  if (signal->completed.load(std::memory_order_seq_cst) >= number && !head.is_triggered(number)) {
    signal->completed.store(number - 1, std::memory_order_seq_cst);
  }
  head.trigger(number);
}

Links links_of(os::Os& os, const graph::Graph& graph, const Region& region) {
  Links links;
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const bool external = graph.nodes()[index].external;
    links.push_back(external ? nullptr : std::make_unique<NodeLink>(os, graph, NodeId(index), region));
  }
  return links;
}

std::vector<SubchainLinks> subchain_links(const graph::Graph& graph, const Links& links, const Region& region) {
  std::vector<SubchainLinks> all;
  for (std::size_t index = 0; index < graph.subchains().size(); ++index) {
    SubchainLinks& subchain = all.emplace_back();
    subchain.signal = &region.signal(SubchainId(index));
    for (const NodeId node : graph.subchains()[index].nodes) subchain.nodes.push_back(links[node.index()].get());
  }
  return all;
}

}  // namespace ctn::runtime
