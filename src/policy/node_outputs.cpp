#include "policy/node_outputs.h"

#include <algorithm>
#include <utility>

namespace ctn::policy {

NodeOutputs::NodeOutputs(const graph::Graph& graph, NodeId node) {
  const std::vector<NodeId>& inputs = graph.node(node).predecessors;
  for (const NodeId input : inputs) limits_.push_back(graph.age_limit(input, node));
  if (!graph.knows_inputs(node)) return;
  predecessors_ = inputs;
  taken_.resize(inputs.size());
}

void NodeOutputs::add(const record::Run& run) {
  const bool new_input = takes_new_input(run);
  if (run.emitted || (new_input && !had_to_skip(run))) estimator_.add(run.emitted);
}

bool NodeOutputs::takes_new_input(const record::Run& run) {
  bool found = predecessors_.empty();
  for (const record::Consumed& input : run.consumed) {
    const auto at = std::find(predecessors_.begin(), predecessors_.end(), input.predecessor) - predecessors_.begin();
    const auto index = static_cast<std::size_t>(at);
    if (index < taken_.size() && std::exchange(taken_[index], input.last) != input.last) found = true;
  }
  return found;
}

bool NodeOutputs::had_to_skip(const record::Run& run) const {
  for (std::size_t index = 0; index < std::min(limits_.size(), run.ages.size()); ++index) {
    const std::optional<graph::AgeLimit>& limit = limits_[index];
    if (limit && limit->on_stale == graph::OnStale::kSkip && run.ages[index] > limit->max_age) return true;
  }
  return false;
}

}  // namespace ctn::policy
