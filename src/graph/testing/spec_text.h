// Specs in few words, for tests: names are separated by spaces, places are left empty.
#pragma once

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "graph/spec.h"

namespace ctn::graph {

inline std::vector<Name> split(const std::string& names) {
  std::istringstream stream(names);
  std::vector<Name> result;
  for (std::string name; stream >> name;) result.push_back({name, {}});
  return result;
}

inline AppSpec spec_of(const std::vector<std::string>& nodes, const std::vector<std::string>& paths) {
  AppSpec spec;
  spec.name.value = "test";
  for (const std::string& name : nodes) spec.nodes.emplace_back().name.value = name;
  for (const std::string& path : paths) spec.edges.push_back({split(path), {}});
  return spec;
}

// Precondition: the spec has such a node.
inline NodeSpec& node(AppSpec& spec, const std::string& name) {
  return *std::find_if(spec.nodes.begin(), spec.nodes.end(),
                       [&](const NodeSpec& node_spec) { return node_spec.name.value == name; });
}

inline SubchainSpec subchain(const std::string& name, const std::string& nodes) { return {{name, {}}, split(nodes)}; }

inline TermSpec response(const std::string& path, double weight) {
  return {Metric::kResponseTime, split(path), {weight, {}}, std::nullopt, {}};
}

inline TermSpec period(const std::string& node_name, double weight) {
  return {Metric::kPeriod, split(node_name), {weight, {}}, std::nullopt, {}};
}

}  // namespace ctn::graph
