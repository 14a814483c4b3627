#include "graph/app.h"

#include <algorithm>
#include <utility>

namespace ctn::graph {

const char* to_string(TriggerBy trigger) {
  switch (trigger) {
    case TriggerBy::kAny:
      return "any";
    case TriggerBy::kTime:
      return "time";
    case TriggerBy::kArrival:
      return "arrival";
  }
  return "";
}

std::optional<NodeId> Graph::find_node(std::string_view name) const {
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), [&](const Node& node) { return node.name == name; });
  if (found == nodes_.end()) return std::nullopt;
  return NodeId(static_cast<std::size_t>(found - nodes_.begin()));
}

std::optional<SubchainId> Graph::find_subchain(std::string_view name) const {
  const auto found = std::find_if(subchains_.begin(), subchains_.end(),
                                  [&](const Subchain& subchain) { return subchain.name == name; });
  if (found == subchains_.end()) return std::nullopt;
  return SubchainId(static_cast<std::size_t>(found - subchains_.begin()));
}

bool Graph::has_edge(NodeId from, NodeId to) const {
  const auto& successors = node(from).successors;
  return std::find(successors.begin(), successors.end(), to) != successors.end();
}

std::optional<AgeLimit> Graph::age_limit(NodeId from, NodeId to) const {
  const auto edge =
      std::find_if(edges_.begin(), edges_.end(), [&](const Edge& each) { return each.from == from && each.to == to; });
  return edge != edges_.end() ? edge->age_limit : std::nullopt;
}

bool Graph::knows_inputs(NodeId id) const {
  const std::vector<NodeId>& inputs = node(id).predecessors;
  return !inputs.empty() &&
         std::none_of(inputs.begin(), inputs.end(), [&](NodeId input) { return node(input).external; });
}

bool Graph::awaits_input(NodeId id) const {
  const Node& of = node(id);
  return of.needs_input && of.subchain && !of.predecessors.empty() &&
         std::none_of(of.predecessors.begin(), of.predecessors.end(),
                      [&](NodeId from) { return node(from).external && !node(from).is_external_clock(); });
}

Nanos Graph::output_period_up_to(NodeId id) const {
  return std::max(output_period_before(id), node(id).output_period.value_or(Nanos{0}));
}

Nanos Graph::output_period_before(NodeId id) const {
  Nanos longest{0};
  const std::optional<SubchainId> of = node(id).subchain;
  if (!of) return longest;
  for (const NodeId each : subchain(*of).nodes) {
    if (each == id) break;
    longest = std::max(longest, node(each).output_period.value_or(Nanos{0}));
  }
  return longest;
}

Graph Graph::needing_input(std::span<const NodeId> needing) const {
  Graph graph = *this;
  for (Node& each : graph.nodes_) each.needs_input = false;
  for (const NodeId id : needing) graph.nodes_[id.index()].needs_input = true;
  return graph;
}

Graph Graph::without_min_rate(NodeId id) const {
  Graph graph = *this;
  graph.nodes_[id.index()].min_rate.reset();
  return graph;
}

Graph Graph::with_min_rate(NodeId id, std::optional<Rate> min_rate) const {
  Graph graph = *this;
  graph.nodes_[id.index()].min_rate = min_rate;
  return graph;
}

Graph Graph::relaxing_exact_rates() const {
  Graph graph = *this;
  for (Node& node : graph.nodes_) node.relaxes_exact_rate = true;
  return graph;
}

Graph Graph::with_subchains(std::vector<Subchain> subchains) const {
  Graph graph = *this;
  graph.subchains_ = std::move(subchains);
  for (std::size_t index = 0; index < graph.subchains_.size(); ++index) {
    for (const NodeId id : graph.subchains_[index].nodes) graph.nodes_[id.index()].subchain = SubchainId(index);
  }
  return graph;
}

std::vector<ChainElement> Graph::chain_elements(std::span<const NodeId> path) const {
  std::vector<ChainElement> elements;
  bool continues = false;  // the node before on the path was of the last element
  for (const NodeId id : path) {
    const Node& current = node(id);
    if (current.external && !current.is_external_clock()) {
      continues = false;
      continue;
    }
    const bool joins = continues && current.subchain && elements.back().subchain == current.subchain;
    if (!joins) {
      const bool follows = continues && current.follows == elements.back().nodes.back();
      elements.push_back({current.subchain, {}, follows});
    }
    elements.back().nodes.push_back(id);
    continues = true;
  }
  return elements;
}

std::string Graph::path_name(std::span<const NodeId> path) const {
  std::string text;
  for (const NodeId id : path) {
    if (!text.empty()) text += " -> ";
    text += node(id).name;
  }
  return text;
}

std::size_t App::kind_of(int core) const {
  std::size_t kind = 0;
  for (int first = 0; kind + 1 < core_kinds.size(); ++kind) {
    first += core_kinds[kind].count;
    if (core < first) break;
  }
  return kind;
}

std::optional<int> App::core_count() const {
  if (core_kinds.empty()) return std::nullopt;
  int count = 0;
  for (const CoreKind& kind : core_kinds) count += kind.count;
  return count;
}

std::vector<int> App::cores_by_kind(int cores) const {
  if (core_kinds.empty()) return {cores};
  std::vector<int> counts;
  for (const CoreKind& kind : core_kinds) {
    counts.push_back(std::clamp(cores, 0, kind.count));
    cores -= counts.back();
  }
  return counts;
}

bool App::has_bounds() const {
  return std::any_of(objective.begin(), objective.end(), [](const Term& term) { return term.max.has_value(); }) ||
         std::any_of(graph.nodes().begin(), graph.nodes().end(), [](const Node& node) { return node.min_rate; });
}

std::vector<SubchainId> App::excluded_by(SubchainId subchain) const {
  std::vector<SubchainId> others;
  for (const NodeId id : graph.subchain(subchain).nodes) {
    const std::optional<std::size_t> group = graph.node(id).exclusive;
    if (!group) continue;
    for (const NodeId other : exclusive[*group].nodes) {
      const std::optional<SubchainId> of = graph.node(other).subchain;
      if (of && *of != subchain) others.push_back(*of);
    }
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  return others;
}

std::vector<std::vector<SubchainId>> App::joined_by_exclusion() const {
  std::vector<std::vector<SubchainId>> joined(graph.subchains().size());
  if (exclusive.empty()) return joined;
  for (std::size_t i = 0; i < joined.size(); ++i) {
    std::vector<SubchainId> found{SubchainId(i)};
    for (std::size_t next = 0; next < found.size(); ++next) {
      for (const SubchainId other : excluded_by(found[next])) {
        if (std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
      }
    }
    joined[i].assign(found.begin() + 1, found.end());
  }
  return joined;
}

double App::weight_of(SubchainId subchain) const {
  double sum = 0.0;
  for (const Term& term : objective) {
    const bool part =
        std::any_of(term.path.begin(), term.path.end(), [&](NodeId id) { return graph.node(id).subchain == subchain; });
    if (part) sum += term.weight;
  }
  return sum;
}

}  // namespace ctn::graph
