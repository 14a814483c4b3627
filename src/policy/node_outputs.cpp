#include "policy/node_outputs.h"

#include <algorithm>
#include <utility>

namespace ctn::policy {

NodeOutputs::NodeOutputs(const graph::Graph& graph, NodeId node) {
  for (const NodeId input : graph.node(node).predecessors) {
    inputs_.push_back({.from = input, .limit = graph.age_limit(input, node), .external = graph.node(input).external});
  }
}

bool NodeOutputs::add(const record::Run& run) {
  const bool new_input = takes_new_input(run);
  last_begin_ = run.begin;
  if (!new_input) idle_.add(!run.emitted, run.cpu);
  if (run.emitted || (new_input && !had_to_skip(run))) estimator_.add(run.emitted);
  return !new_input && !run.emitted;
}

void NodeOutputs::set_clock(NodeId node, const Ticks& ticks) {
  for (Input& input : inputs_) {
    if (input.external && input.from == node) input.clock = ticks;
  }
}

bool NodeOutputs::takes_new_input(const record::Run& run) {
  bool found = inputs_.empty();
  for (const record::Consumed& consumed : run.consumed) {
    const auto input = std::find_if(inputs_.begin(), inputs_.end(),
                                    [&](const Input& one) { return one.from == consumed.predecessor; });
    if (input != inputs_.end() && std::exchange(input->taken, consumed.last) != consumed.last) found = true;
  }
  if (found) return true;
  return std::any_of(inputs_.begin(), inputs_.end(), [&](const Input& input) {
    if (!input.external) return false;
    return input.clock.period == Nanos{0} || !last_begin_ || input.clock.last(run.begin) > *last_begin_;
  });
}

bool NodeOutputs::had_to_skip(const record::Run& run) const {
  for (std::size_t index = 0; index < std::min(inputs_.size(), run.ages.size()); ++index) {
    const std::optional<graph::AgeLimit>& limit = inputs_[index].limit;
    if (limit && limit->on_stale == graph::OnStale::kSkip && run.ages[index] > limit->max_age) return true;
  }
  return false;
}

}  // namespace ctn::policy
