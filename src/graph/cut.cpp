#include "graph/cut.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace ctn::graph {
namespace {

// A subchain's nodes, up to each that has a rate of its own.
std::vector<Subchain> parts_of(const Graph& graph, const Subchain& whole) {
  std::vector<Subchain> parts;
  for (const NodeId id : whole.nodes) {
    const Node& node = graph.node(id);
    if (parts.empty()) {
      parts.push_back({whole.name, {}, whole.implicit});
    } else if (node.fallback_rate) {
      parts.push_back({node.name, {}, false});
    }
    parts.back().nodes.push_back(id);
  }
  for (std::size_t part = 1; part < parts.size(); ++part) parts[part].implicit = parts[part].nodes.size() == 1;
  return parts;
}

}  // namespace

App cut_at_fallback_rates(const App& app) {
  // As an app file would have them: those that it names, then single nodes in their order.
  struct Part {
    Subchain subchain;
    SubchainId of;  // before
  };
  std::vector<Part> parts;
  for (std::size_t index = 0; index < app.graph.subchains().size(); ++index) {
    for (Subchain& part : parts_of(app.graph, app.graph.subchains()[index])) {
      parts.push_back({std::move(part), SubchainId(index)});
    }
  }
  const auto single =
      std::stable_partition(parts.begin(), parts.end(), [](const Part& part) { return !part.subchain.implicit; });
  std::sort(single, parts.end(), [](const Part& a, const Part& b) { return a.subchain.head() < b.subchain.head(); });

  const auto with_parts = [&](const std::vector<SubchainId>& list) {
    std::vector<SubchainId> longer;
    for (const SubchainId id : list) {
      const std::vector<NodeId>& nodes = app.graph.subchain(id).nodes;
      for (const NodeId head : nodes) {
        const auto part = std::find_if(parts.begin(), parts.end(),
                                       [&](const Part& each) { return each.of == id && each.subchain.head() == head; });
        if (part != parts.end()) longer.emplace_back(static_cast<std::size_t>(part - parts.begin()));
      }
    }
    return longer;
  };
  App cut = app;
  cut.order = with_parts(app.order);
  cut.steal.priority = with_parts(app.steal.priority);
  cut.steal.off = with_parts(app.steal.off);
  std::vector<Subchain> subchains;
  std::transform(parts.begin(), parts.end(), std::back_inserter(subchains),
                 [](Part& part) { return std::move(part.subchain); });
  cut.graph = app.graph.with_subchains(std::move(subchains));
  return cut;
}

}  // namespace ctn::graph
