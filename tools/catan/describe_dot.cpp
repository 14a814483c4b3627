#include <fmt/format.h>

#include <algorithm>

#include "config/quantity.h"
#include "describe.h"

namespace ctn::tool {
namespace {

// One triggers the other: neighbours in a subchain.
bool triggers(const graph::Graph& graph, const graph::Edge& edge) {
  const auto subchain = graph.node(edge.from).subchain;
  if (!subchain || graph.node(edge.to).subchain != subchain) return false;
  const auto& nodes = graph.subchain(*subchain).nodes;
  const auto from = std::find(nodes.begin(), nodes.end(), edge.from);
  return from != nodes.end() && from + 1 != nodes.end() && *(from + 1) == edge.to;
}

std::string node_line(const graph::Graph& graph, NodeId id, const model::CostTable* costs) {
  const graph::Node& node = graph.node(id);
  const char* style = node.external ? "shape=box, style=dotted" : node.unscheduled ? "style=dashed" : "style=solid";
  std::string label = node.name;
  if (costs != nullptr && !node.external) label += fmt::format("\\n{:.6g}ms", (*costs)[id].single_thread().count());
  return fmt::format("\"{}\" [label=\"{}\", {}];\n", node.name, label, style);
}

}  // namespace

// Names hold no quotes and no backslashes (graph/build_nodes.cpp), so that they need no escaping.
std::string describe_dot(const graph::App& app, const model::CostTable* costs) {
  const graph::Graph& graph = app.graph;
  std::string text = fmt::format("digraph \"{}\" {{\n  rankdir=LR;\n", app.name);
  for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
    if (!graph.node(NodeId(i)).subchain) text += "  " + node_line(graph, NodeId(i), costs);
  }
  for (std::size_t i = 0; i < graph.subchains().size(); ++i) {
    const graph::Subchain& subchain = graph.subchain(SubchainId(i));
    const std::string label = subchain.implicit ? "" : subchain.name;
    text += fmt::format("  subgraph \"cluster_{}\" {{\n    label=\"{}\";\n", i, label);
    for (const NodeId id : subchain.nodes) text += "    " + node_line(graph, id, costs);
    text += "  }\n";
  }
  for (const graph::Edge& edge : graph.edges()) {
    std::vector<std::string> settings;
    if (triggers(graph, edge)) settings.emplace_back("style=bold");
    if (edge.age_limit) {
      settings.push_back(fmt::format("label=\"max {}{}\"", config::format_duration(edge.age_limit->max_age),
                                     edge.age_limit->on_stale == graph::OnStale::kSkip ? ", else skip" : ""));
    }
    text += fmt::format("  \"{}\" -> \"{}\"{};\n", graph.node(edge.from).name, graph.node(edge.to).name,
                        settings.empty() ? "" : fmt::format(" [{}]", fmt::join(settings, ", ")));
  }
  return text + "}\n";
}

}  // namespace ctn::tool
