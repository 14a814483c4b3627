#include "runtime/unscheduled_watch.h"

#include <fmt/format.h>

#include <atomic>

namespace ctn::runtime {

UnscheduledWatch::UnscheduledWatch(const graph::Graph& graph, const Region& region, const Links& links,
                                   RegisteredNodes& registered)
    : graph_(graph), region_(region), links_(links), registered_(registered) {
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    if (graph.nodes()[index].unscheduled && links[index]) watched_.push_back({.node = NodeId(index)});
  }
}

Nanos UnscheduledWatch::cpu_time_of(NodeId node) const {
  Nanos used{0};
  links_[node.index()]->for_each_clock(
      [&](os::ThreadId, os::CpuClock& clock) { used += clock.now().value_or(Nanos{0}); });
  return used;
}

void UnscheduledWatch::look(const std::function<void(const std::string&)>& notice) {
  for (Watched& each : watched_) {
    const std::uint64_t number = region_.node(each.node).number.load(std::memory_order_acquire);
    const Nanos used = cpu_time_of(each.node);
    // Less than before: a thread has ended.
    if (number != each.number || used < each.used_before) {
      each.number = number;
      each.used_before = used;
      if (each.lowered) registered_.raise_again(each.node);
      each.lowered = false;
      continue;
    }
    if (used - each.used_before < kMaxCpuTime) continue;
    // Each time: a thread may have joined, or the level of unscheduled nodes may have changed.
    registered_.lower(each.node);
    if (each.lowered) continue;
    each.lowered = true;
    notice(fmt::format("run {} of {} has used {} s of CPU time: its threads are at the ordinary level until the next",
                       number, graph_.node(each.node).name,
                       std::chrono::duration_cast<std::chrono::seconds>(kMaxCpuTime).count()));
  }
}

}  // namespace ctn::runtime
