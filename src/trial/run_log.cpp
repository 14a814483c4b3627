#include "trial/run_log.h"

#include <utility>

namespace ctn::trial {

RunLog::RunLog(const graph::App& app, Observer& observer) : observer_(observer), nodes_(app.graph.nodes().size()) {
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    const graph::Node& described = app.graph.nodes()[index];
    Node& node = nodes_[index];
    node.run.node = NodeId(index);
    node.queue = described.input == graph::InputKind::kQueue;
    for (const NodeId predecessor : described.predecessors) {
      nodes_[predecessor.index()].outputs.push_back({NodeId(index), node.inputs.size()});
      node.inputs.push_back({.predecessor = predecessor});
    }
  }
}

void RunLog::begin(NodeId id, TimePoint now) {
  Node& node = nodes_[id.index()];
  ++node.run.number;
  node.run.begin = now;
  node.run.consumed.clear();
  for (Input& input : node.inputs) {
    if (input.newest == 0) continue;
    const std::uint64_t before = std::exchange(input.taken, input.newest);
    input.waiting = 0;
    if (!node.queue) {
      node.run.consumed.push_back({input.predecessor, input.newest, input.newest});
    } else if (input.newest > before) {
      node.run.consumed.push_back({input.predecessor, before + 1, input.newest});
    }
  }
}

void RunLog::end(NodeId id, TimePoint now, bool emitted) {
  Node& node = nodes_[id.index()];
  node.run.end = now;
  node.run.emitted = emitted;
  observer_.ended(node.run);
  if (!emitted) return;
  for (const Output& output : node.outputs) {
    Node& consumer = nodes_[output.node.index()];
    Input& input = consumer.inputs[output.input];
    if (consumer.queue && input.waiting == kQueueCapacity) continue;
    ++input.waiting;
    input.newest = node.run.number;
  }
}

}  // namespace ctn::trial
