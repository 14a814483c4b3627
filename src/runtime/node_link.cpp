#include "runtime/node_link.h"

#include <algorithm>
#include <utility>

namespace ctn::runtime {

NodeLink::NodeLink(os::Os& os, const graph::Graph& graph, NodeId node, const Region& region)
    : os_(os),
      node_(node),
      predecessors_(graph.node(node).predecessors),
      cell_(region.node(node)),
      reports_(region.reports_reader(node)) {}

bool NodeLink::announce_thread(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  return announce(thread).has_value();
}

void NodeLink::withdraw_thread(os::ThreadId thread) {
  const std::lock_guard lock(mutex_);
  if (const auto index = announced_at(thread)) places_[*index] = Place::kFree;
  publish_threads();
}

bool NodeLink::add_thread(os::ThreadId thread) {
  Result<std::unique_ptr<os::CpuClock>> clock = os_.cpu_clock(thread);
  const std::lock_guard lock(mutex_);
  const std::optional<std::size_t> index = announce(thread);
  if (!index) return false;
  if (clock) clocks_[*index] = *std::move(clock);
  places_[*index] = Place::kAdded;
  threads_[*index].store(owners_[*index], std::memory_order_seq_cst);
  publish_threads();
  joined_.fetch_add(1, std::memory_order_release);
  return true;
}

std::optional<std::size_t> NodeLink::announced_at(os::ThreadId thread) const {
  for (std::size_t index = 0; index < places_.size(); ++index) {
    if (places_[index] == Place::kAnnounced && owners_[index] == static_cast<std::int32_t>(thread)) return index;
  }
  return std::nullopt;
}

std::optional<std::size_t> NodeLink::announce(os::ThreadId thread) {
  if (const auto index = announced_at(thread)) return index;
  const auto* const free = std::find(places_.begin(), places_.end(), Place::kFree);
  if (free == places_.end()) return std::nullopt;
  const auto index = static_cast<std::size_t>(free - places_.begin());
  places_[index] = Place::kAnnounced;
  owners_[index] = static_cast<std::int32_t>(thread);
  publish_threads();
  return index;
}

void NodeLink::remove_thread(os::ThreadId thread, const Restore& restore) {
  remove_if([&](std::int32_t each) { return each == static_cast<std::int32_t>(thread); }, restore);
}

void NodeLink::remove_all_threads(const Restore& restore) {
  remove_if([](std::int32_t) { return true; }, restore);
}

template <class IsMeant>
void NodeLink::remove_if(const IsMeant& is_meant, const Restore& restore) {
  std::vector<std::size_t> removed;
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t index = 0; index < places_.size(); ++index) {
      if (places_[index] != Place::kAdded || !is_meant(owners_[index])) continue;
      places_[index] = Place::kLeaving;
      threads_[index].store(0, std::memory_order_seq_cst);
      removed.push_back(index);
    }
    publish_threads();
  }
  wait_for_visitors();
  // Nobody else changes the place of one that is leaving.
  for (const std::size_t index : removed) restore(os::ThreadId{owners_[index]});
  const std::lock_guard lock(mutex_);
  for (const std::size_t index : removed) {
    clocks_[index].reset();
    places_[index] = Place::kFree;
  }
  publish_threads();
}

// Visits are a few system calls long, of threads that outrank us; visits that begin now do not see the thread any more.
void NodeLink::wait_for_visitors() const {
  constexpr Nanos kPause = std::chrono::microseconds{50};
  while (visitors_.load(std::memory_order_seq_cst) != 0) os_.sleep_until(os_.now() + kPause);
}

// Also for the node, which adds up what its threads used.
void NodeLink::publish_threads() {
  std::size_t added = 0;
  std::size_t listed = 0;
  for (std::size_t index = 0; index < places_.size(); ++index) {
    const bool free = places_[index] == Place::kFree;
    cell_.thread[index].store(free ? 0 : owners_[index], std::memory_order_release);
    if (!free) listed = index + 1;
    if (places_[index] == Place::kAdded) added = index + 1;
  }
  used_.store(added, std::memory_order_release);
  cell_.threads.store(static_cast<std::uint32_t>(listed), std::memory_order_release);
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

void NodeLink::wake() { os_.wake(cell_.word); }

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
