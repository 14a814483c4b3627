#include "policy/batch_sizes.h"

#include <algorithm>

#include "catan/channel.h"

namespace ctn::policy {

BatchSizes::BatchSizes(const graph::Graph& graph) : queues_(graph.nodes().size()), outputs_(graph.nodes().size()) {
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const graph::Node& node = graph.nodes()[index];
    if (node.input != graph::InputKind::kQueue) continue;
    for (const NodeId from : node.predecessors) {
      outputs_[from.index()].push_back({index, queues_[index].size()});
      queues_[index].push_back({from, {}});
    }
  }
}

std::size_t BatchSizes::taken_by(const record::Run& run) {
  std::size_t items = 0;
  for (Queue& queue : queues_[run.node.index()]) {
    const auto input = std::find_if(run.consumed.begin(), run.consumed.end(), [&](const record::Consumed& consumed) {
      return consumed.predecessor == queue.from;
    });
    if (input == run.consumed.end()) continue;
    std::deque<std::uint64_t>& waiting = queue.waiting;
    const auto first = std::lower_bound(waiting.begin(), waiting.end(), input->first);
    const auto last = std::upper_bound(first, waiting.end(), input->last);
    items += static_cast<std::size_t>(last - first);
    waiting.erase(waiting.begin(), last);
  }
  return items;
}

void BatchSizes::ended(const record::Run& run) {
  if (!run.emitted) return;
  for (const Output& output : outputs_[run.node.index()]) {
    std::deque<std::uint64_t>& waiting = queues_[output.node][output.queue].waiting;
    // What finds a full queue is lost.
    if (waiting.size() < QueueChannel<int>::kCapacity) waiting.push_back(run.number);
  }
}

}  // namespace ctn::policy
