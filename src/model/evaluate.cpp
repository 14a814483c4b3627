#include "model/evaluate.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "model/unscheduled.h"

namespace ctn::model {
namespace {

ElementTiming evaluate_element(const graph::Graph& graph, const graph::ChainElement& element, const CostTable& costs,
                               std::span<const SubchainTiming> subchains, std::span<const Millis> kept_waiting) {
  ElementTiming timing;
  if (element.subchain) {
    const SubchainTiming& subchain = subchains[element.subchain->index()];
    timing.period = subchain.period;
    timing.execution = subchain.execution;
    timing.wait = subchain.longest_gap;
    const graph::Subchain& described = graph.subchain(*element.subchain);
    timing.runs_per_output = costs.runs_per_output(described, element.nodes.back());
    timing.left_out = left_out(graph, costs, described, element.nodes.back()).most(timing.execution);
  } else {
    const NodeId node = element.nodes.front();
    timing.period = evaluate_period(graph, node, subchains);
    timing.execution = costs[node].single_thread() + costs.wait(node) + unscheduled_wait_of(kept_waiting, node);
    timing.runs_per_output = costs.runs_per_output(node);
    if (const std::optional<NodeId> leader = graph.node(node).follows) {
      timing.wait = timing.period + output_lateness(graph, costs, kept_waiting, *leader, 0.0);
    }
    if (timing.execution > timing.wait.value_or(timing.period)) timing.wait = timing.execution;
    timing.left_out = left_out(graph.node(node)).most(timing.execution);
  }
  timing.output_period = to_millis(graph.output_period_up_to(element.nodes.back()));
  return timing;
}

// Of one that the next element follows: that one's period is what outputs are apart on average, and has the rest.
Millis left_out_beside_period(const graph::Graph& graph, const graph::ChainElement& element,
                              const ElementTiming& timing, const CostTable& costs) {
  if (!element.subchain) return timing.left_out + timing.runs_per_output * timing.period - timing.outputs_apart();
  return outputs_late(graph, costs, graph.subchain(*element.subchain), timing.period, timing.execution);
}

bool is_triggered_by(const graph::ChainElement& element, const graph::ChainElement& before,
                     std::span<const SubchainTiming> subchains) {
  if (!element.subchain) return element.follows;
  const SubchainTiming& timing = subchains[element.subchain->index()];
  return before.subchain ? timing.follows == before.subchain : timing.follows_node == before.nodes.front();
}

// Where both keep phases to one clock.
std::optional<InputWait> wait_in_step(const graph::ChainElement& element, const graph::ChainElement& before,
                                      std::span<const SubchainTiming> subchains) {
  if (!element.subchain || !before.subchain) return std::nullopt;
  const SubchainTiming& giver = subchains[before.subchain->index()];
  const auto& from = giver.by_phase;
  const auto& to = subchains[element.subchain->index()].by_phase;
  if (!from || !to || from->clock != to->clock) return std::nullopt;
  const bool below = to->core == from->core && to->priority < from->priority && from->runs_through;
  const auto step = InStep::of(from->grid, to->grid);
  if (!step) return std::nullopt;
  return step->wait(giver.execution, below);
}

}  // namespace

ChainTiming evaluate_chain(const graph::Graph& graph, std::span<const NodeId> path, const CostTable& costs,
                           std::span<const SubchainTiming> subchains, std::span<const Millis> kept_waiting) {
  std::vector<ElementTiming> elements;
  const graph::ChainElement* before = nullptr;
  // Each run of the element before brings something new: it is the first, or has kept step and was never the faster.
  bool all_new = true;
  // All since the first follow the one before: the period of the chain has in it what they leave out.
  bool in_line = true;
  const std::vector<graph::ChainElement> chain = graph.chain_elements(path);
  for (const graph::ChainElement& element : chain) {
    elements.push_back(evaluate_element(graph, element, costs, subchains, kept_waiting));
    if (before != nullptr && is_triggered_by(element, *before, subchains)) {
      ElementTiming& leader = elements[elements.size() - 2];
      elements.back().wait = in_line ? Millis{0} : std::max(elements.back().period - leader.period, Millis{0});
      leader.left_out = left_out_beside_period(graph, *before, leader, costs);
      all_new = false;
    } else if (before != nullptr) {
      in_line = false;
      const std::optional<InputWait> wait = wait_in_step(element, *before, subchains);
      if (wait) elements.back().wait = all_new ? wait->last : wait->last + wait->more;
      all_new = all_new && wait && elements.back().period >= elements[elements.size() - 2].outputs_apart();
    }
    before = &element;
  }
  return chain_timing(elements);
}

Millis evaluate_period(const graph::Graph& graph, NodeId node, std::span<const SubchainTiming> subchains) {
  const graph::Node& described = graph.node(node);
  if (described.subchain) {
    return std::max(subchains[described.subchain->index()].period, to_millis(graph.output_period_before(node)));
  }
  return to_millis(described.period.value_or(Nanos{0}));
}

}  // namespace ctn::model
