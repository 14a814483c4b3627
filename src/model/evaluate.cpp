#include "model/evaluate.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace ctn::model {
namespace {

std::optional<Millis> longest_output_period(const graph::Graph& graph, std::span<const NodeId> nodes) {
  std::optional<Millis> longest;
  for (const NodeId id : nodes) {
    const std::optional<Nanos>& period = graph.node(id).output_period;
    if (period) longest = std::max(longest.value_or(Millis{0}), to_millis(*period));
  }
  return longest;
}

ElementTiming evaluate_element(const graph::Graph& graph, const graph::ChainElement& element, const CostTable& costs,
                               std::span<const SubchainTiming> subchains) {
  ElementTiming timing;
  if (element.subchain) {
    const SubchainTiming& subchain = subchains[element.subchain->index()];
    timing.period = subchain.period;
    timing.execution = subchain.execution;
  } else {
    const NodeId node = element.nodes.front();
    timing.period = evaluate_period(graph, node, subchains);
    timing.execution = costs[node].single_thread() + costs.wait(node);
  }
  timing.output_period = longest_output_period(graph, element.nodes);
  return timing;
}

// Of the input that the element takes from the one before; none: it may be as long as its period.
std::optional<Millis> wait_for_input(const graph::ChainElement& element, const graph::ChainElement& before,
                                     std::span<const SubchainTiming> subchains) {
  if (element.follows) return Millis{0};
  if (!element.subchain) return std::nullopt;
  const SubchainTiming& timing = subchains[element.subchain->index()];
  if (!before.subchain) {
    return timing.follows_node == before.nodes.front() ? std::optional(Millis{0}) : std::nullopt;
  }
  if (timing.follows == before.subchain) return Millis{0};
  const SubchainTiming& giver = subchains[before.subchain->index()];
  if (!timing.by_phase || !giver.by_phase || timing.by_phase->clock != giver.by_phase->clock) return std::nullopt;
  const bool below = timing.by_phase->core == giver.by_phase->core &&
                     timing.by_phase->priority < giver.by_phase->priority && giver.by_phase->runs_through;
  return wait_between(giver.by_phase->grid, giver.execution, timing.by_phase->grid, below);
}

}  // namespace

ChainTiming evaluate_chain(const graph::Graph& graph, std::span<const NodeId> path, const CostTable& costs,
                           std::span<const SubchainTiming> subchains) {
  std::vector<ElementTiming> elements;
  const graph::ChainElement* before = nullptr;
  const std::vector<graph::ChainElement> chain = graph.chain_elements(path);
  for (const graph::ChainElement& element : chain) {
    elements.push_back(evaluate_element(graph, element, costs, subchains));
    if (before != nullptr) elements.back().wait = wait_for_input(element, *before, subchains);
    before = &element;
  }
  return chain_timing(elements);
}

Millis evaluate_period(const graph::Graph& graph, NodeId node, std::span<const SubchainTiming> subchains) {
  const graph::Node& described = graph.node(node);
  if (described.subchain) return subchains[described.subchain->index()].period;
  return to_millis(described.period.value_or(Nanos{0}));
}

}  // namespace ctn::model
