// A node's inputs as its runs know them (include/catan/run.h): by predecessor, with their age limits. No channels yet.
#pragma once

#include <optional>
#include <vector>

#include "base/run_access.h"
#include "graph/app.h"

namespace ctn::record {

inline std::vector<RunAccess::InputEdge> input_edges(const graph::Graph& graph, NodeId node) {
  std::vector<RunAccess::InputEdge> edges;
  for (const NodeId input : graph.node(node).predecessors) {
    RunAccess::InputEdge& edge = edges.emplace_back();
    edge.from = graph.node(input).name;
    edge.queue = graph.node(node).input == graph::InputKind::kQueue;
    const std::optional<graph::AgeLimit> limit = graph.age_limit(input, node);
    if (!limit) continue;
    edge.max_age = limit->max_age;
    edge.skips = limit->on_stale == graph::OnStale::kSkip;
  }
  return edges;
}

}  // namespace ctn::record
