// Random specs, most of them wrong somewhere: build_app never crashes, gives a reason for every refusal, and whatever
// it builds keeps the invariants of app.h.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::graph {
namespace {

// Few names, so that they meet; the higher the number of nodes declared, the fewer of them dangle.
rc::Gen<std::string> any_name(int nodes) {
  return rc::gen::map(rc::gen::inRange(0, nodes), [](int i) { return "n" + std::to_string(i); });
}

// A path over rising numbers is no cycle; one in twenty is any path.
std::string any_path(int nodes) {
  std::set<int> steps;
  const int length = *rc::gen::inRange(2, 6);
  for (int i = 0; i < length; ++i) steps.insert(*rc::gen::inRange(0, nodes));
  if (steps.size() < 2 && nodes > 1) steps.insert({0, nodes - 1});
  std::string path;
  for (const int step : steps) path += "n" + std::to_string(step) + " ";
  if (*rc::gen::inRange(0, 40) == 0) path += *any_name(nodes);
  return path;
}

NodeSpec any_node(int index) {
  NodeSpec node;
  node.name.value = "n" + std::to_string(index);
  const int kind = *rc::gen::inRange(0, 10);
  node.external = kind == 8;
  node.unscheduled = kind == 9;
  const auto sometimes = [] { return *rc::gen::inRange(0, 60) == 0; };
  if (node.unscheduled != sometimes()) node.period = At<Nanos>{Nanos{*rc::gen::inRange(0, 1'000'000)}, {}};
  if (sometimes()) node.output_period = At<Nanos>{std::chrono::milliseconds{5}, {}};
  if (sometimes()) node.min_rate = At<Rate>{Rate{*rc::gen::inRange(1, 100) * 1.0}, {}};
  if (sometimes()) node.max_rate = At<Rate>{Rate{*rc::gen::inRange(1, 100) * 1.0}, {}};
  if (sometimes()) node.fallback_rate = At<Rate>{Rate{*rc::gen::inRange(1, 100) * 1.0}, {}};
  if (sometimes()) node.max_threads = At<int>{*rc::gen::inRange(0, 8), {}};
  if (sometimes()) node.input = InputKind::kQueue;
  return node;
}

AppSpec any_spec() {
  AppSpec spec;
  spec.name.value = "any";
  const int nodes = *rc::gen::inRange(1, 9);
  for (int i = 0; i < nodes; ++i) spec.nodes.push_back(any_node(i));
  const int paths = *rc::gen::inRange(0, nodes / 2 + 1);
  for (int i = 0; i < paths; ++i) spec.edges.push_back({split(any_path(nodes)), {}});
  // Mostly subchains and terms that follow an edge.
  const auto known_path = [&] {
    if (paths == 0 || *rc::gen::inRange(0, 6) == 0) return split(*any_name(nodes));
    return spec.edges[static_cast<std::size_t>(*rc::gen::inRange(0, paths))].nodes;
  };
  const int subchains = *rc::gen::inRange(0, 3);
  for (int i = 0; i < subchains; ++i) {
    spec.subchains.push_back(
        {{*rc::gen::inRange(0, 6) == 0 ? *any_name(nodes) : "s" + std::to_string(i), {}}, known_path()});
  }
  const int terms = *rc::gen::inRange(1, 3);
  for (int i = 0; i < terms; ++i) {
    TermSpec term = response("", *rc::gen::inRange(0, 5));
    term.path = known_path();
    if (*rc::gen::inRange(0, 4) == 0) term = period(*any_name(nodes), 1.0);
    if (*rc::gen::inRange(0, 4) == 0) term.max = At<Nanos>{std::chrono::milliseconds{9}, {}};
    spec.objective.push_back(term);
  }
  return spec;
}

void check_partition(const App& app) {
  std::map<NodeId, int> owners;
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    const Subchain& subchain = app.graph.subchain(SubchainId(i));
    RC_ASSERT(!subchain.nodes.empty());
    RC_ASSERT(app.graph.find_subchain(subchain.name) == SubchainId(i));
    for (std::size_t j = 0; j < subchain.nodes.size(); ++j) {
      RC_ASSERT(app.graph.node(subchain.nodes[j]).subchain == SubchainId(i));
      if (j > 0) RC_ASSERT(app.graph.has_edge(subchain.nodes[j - 1], subchain.nodes[j]));
      ++owners[subchain.nodes[j]];
    }
  }
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    const Node& node = app.graph.node(NodeId(i));
    RC_ASSERT(app.graph.find_node(node.name) == NodeId(i));
    RC_ASSERT((node.external ? 1 : 0) + (node.unscheduled ? 1 : 0) + owners[NodeId(i)] == 1);
    if (!node.external) RC_ASSERT(node.unscheduled == node.period.has_value());
    if (node.follows) {
      const Node& followed = app.graph.node(*node.follows);
      RC_ASSERT(node.unscheduled && followed.unscheduled && app.graph.has_edge(*node.follows, NodeId(i)));
      RC_ASSERT(*node.period >= *followed.period);
    }
    RC_ASSERT(node.max_threads >= 1);
    RC_ASSERT(!node.min_rate || !node.max_rate || *node.min_rate <= *node.max_rate);
  }
}

void check_order(const App& app) {
  const auto order = app.graph.topological_order();
  RC_ASSERT(order.size() == app.graph.nodes().size());
  std::map<NodeId, std::size_t> position;
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = i;
  RC_ASSERT(position.size() == order.size());
  for (const Edge& edge : app.graph.edges()) RC_ASSERT(position[edge.from] < position[edge.to]);
  for (const auto& ranking : {app.order, app.steal.priority}) {
    RC_ASSERT(std::set(ranking.begin(), ranking.end()).size() == app.graph.subchains().size());
    RC_ASSERT(ranking.size() == app.graph.subchains().size());
  }
  const auto& steal = app.steal.priority;
  RC_ASSERT(std::is_sorted(steal.begin(), steal.end(),
                           [&](SubchainId a, SubchainId b) { return app.weight_of(a) > app.weight_of(b); }));
}

// Along the heaviest term's chain, a subchain has its slot before those that use what it gives.
void check_slots_follow_data(const App& app) {
  const auto heaviest = std::max_element(app.objective.begin(), app.objective.end(),
                                         [](const Term& a, const Term& b) { return a.weight < b.weight; });
  if (heaviest->weight <= 0.0) return;
  std::vector<SubchainId> chain;
  for (const NodeId node : heaviest->path) {
    const auto subchain = app.graph.node(node).subchain;
    if (subchain && (chain.empty() || chain.back() != *subchain)) chain.push_back(*subchain);
  }
  if (std::set(chain.begin(), chain.end()).size() != chain.size()) return;  // comes back to one: no order serves all
  const auto place = [&](SubchainId id) { return std::find(app.order.begin(), app.order.end(), id); };
  for (std::size_t i = 1; i < chain.size(); ++i) RC_ASSERT(place(chain[i - 1]) < place(chain[i]));
}

void check_objective(const App& app) {
  RC_ASSERT(!app.objective.empty());
  for (const Term& term : app.objective) {
    RC_ASSERT(term.weight >= 0.0);
    const auto elements = app.graph.chain_elements(term.path);
    RC_ASSERT(!elements.empty());
    std::size_t covered = 0;
    for (const ChainElement& element : elements) {
      RC_ASSERT(!element.nodes.empty());
      covered += element.nodes.size();
      for (const NodeId id : element.nodes) RC_ASSERT(app.graph.node(id).subchain == element.subchain);
    }
    const auto left_out = std::count_if(term.path.begin(), term.path.end(), [&](NodeId id) {
      return app.graph.node(id).external && !app.graph.node(id).is_external_clock();
    });
    RC_ASSERT(covered + static_cast<std::size_t>(left_out) == term.path.size());
  }
}

RC_GTEST_PROP(BuildAppProperty, WhateverIsBuiltKeepsTheInvariants, ()) {
  const AppSpec spec = any_spec();
  const auto app = build_app(spec);
  RC_CLASSIFY(app.ok(), "built");
  if (!app.ok()) {
    for (const Problem& problem : app.error().problems()) RC_ASSERT(!problem.what.empty() && !problem.hint.empty());
    return;
  }
  check_partition(*app);
  check_order(*app);
  check_slots_follow_data(*app);
  check_objective(*app);
}

}  // namespace
}  // namespace ctn::graph
