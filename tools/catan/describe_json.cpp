#include <nlohmann/json.hpp>

#include "describe.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;

double millis(Nanos duration) { return to_millis(duration).count(); }

Json node_names(const graph::Graph& graph, const std::vector<NodeId>& ids) {
  Json names = Json::array();
  for (const NodeId id : ids) names.push_back(graph.node(id).name);
  return names;
}

Json subchain_names(const graph::Graph& graph, const std::vector<SubchainId>& ids) {
  Json names = Json::array();
  for (const SubchainId id : ids) names.push_back(graph.subchain(id).name);
  return names;
}

Json node_json(const graph::Graph& graph, NodeId id, const model::CostTable* costs) {
  const graph::Node& node = graph.node(id);
  Json json{{"kind", node.external ? "external" : node.unscheduled ? "unscheduled" : "scheduled"}};
  json["inputs"] = node_names(graph, node.predecessors);
  if (node.subchain) json["subchain"] = graph.subchain(*node.subchain).name;
  if (!node.external) json["input"] = node.input == graph::InputKind::kQueue ? "queue" : "latest";
  if (!node.modes.empty()) json["modes"] = node.modes;
  if (node.period) json["period_ms"] = millis(*node.period);
  if (node.follows) json["follows"] = graph.node(*node.follows).name;
  if (node.output_period) json["output_period_ms"] = millis(*node.output_period);
  if (node.min_rate) json["min_rate_hz"] = node.min_rate->hertz();
  if (node.max_rate) json["max_rate_hz"] = node.max_rate->hertz();
  if (node.fallback_rate) json["fallback_rate_hz"] = node.fallback_rate->hertz();
  if (node.trigger != graph::TriggerBy::kAny) json["trigger"] = to_string(node.trigger);
  if (node.subchain) json["max_threads"] = node.max_threads;
  if (costs != nullptr && !node.external) json["cost_ms"] = (*costs)[id].single_thread().count();
  if (costs != nullptr && costs->has_batches(id)) json["per_item_ms"] = (*costs)[id].per_item().count();
  return json;
}

Json term_json(const graph::Graph& graph, const graph::Term& term) {
  if (term.metric == graph::Metric::kPeriod) {
    return {{"period", graph.node(term.path.front()).name}, {"weight", term.weight}};
  }
  Json json{{"response_time", node_names(graph, term.path)}, {"weight", term.weight}};
  if (term.max) json["max_ms"] = millis(*term.max);
  json["elements"] = Json::array();
  for (const graph::ChainElement& element : graph.chain_elements(term.path)) {
    Json entry;
    if (element.subchain) entry["subchain"] = graph.subchain(*element.subchain).name;
    entry["nodes"] = node_names(graph, element.nodes);
    json["elements"].push_back(std::move(entry));
  }
  return json;
}

Json scheduler_json(const graph::SchedulerOptions& options) {
  return {{"slack", options.slack ? Json(*options.slack) : Json("auto")},
          {"frames", options.frames == graph::FrameMode::kElastic ? "elastic" : "fixed"},
          {"min_slice_ms", millis(options.min_slice)},
          {"window", options.window},
          {"percentile", options.percentile},
          {"bootstrap_ms", millis(options.bootstrap)},
          {"bootstrap_cost_ms", millis(options.bootstrap_cost)},
          {"replan_ms", millis(options.replan)}};
}

}  // namespace

std::string describe_json(const graph::App& app, const model::CostTable* costs) {
  const graph::Graph& graph = app.graph;
  Json json{{"app", app.name}, {"nodes", Json::object()}, {"edges", Json::array()}, {"subchains", Json::object()}};
  if (!app.core_kinds.empty()) json["cores"] = Json::object();
  for (const graph::CoreKind& kind : app.core_kinds) {
    json["cores"][kind.name] = {{"count", kind.count}, {"speed", kind.speed}};
  }
  for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
    json["nodes"][graph.node(NodeId(i)).name] = node_json(graph, NodeId(i), costs);
  }
  for (const graph::Edge& edge : graph.edges()) {
    json["edges"].push_back({graph.node(edge.from).name, graph.node(edge.to).name});
  }
  json["age_limits"] = Json::array();
  for (const graph::Edge& edge : graph.edges()) {
    if (!edge.age_limit) continue;
    json["age_limits"].push_back({{"from", graph.node(edge.from).name},
                                  {"to", graph.node(edge.to).name},
                                  {"max_age_ms", millis(edge.age_limit->max_age)},
                                  {"on_stale", edge.age_limit->on_stale == graph::OnStale::kSkip ? "skip" : "run"}});
  }
  for (std::size_t i = 0; i < graph.subchains().size(); ++i) {
    const graph::Subchain& subchain = graph.subchain(SubchainId(i));
    Json entry{{"nodes", node_names(graph, subchain.nodes)},
               {"implicit", subchain.implicit},
               {"weight", app.weight_of(SubchainId(i))}};
    if (costs != nullptr) entry["cost_ms"] = costs->subchain_total(graph, SubchainId(i)).count();
    json["subchains"][subchain.name] = std::move(entry);
  }
  json["exclusive"] = Json::object();
  for (const graph::ExclusiveGroup& group : app.exclusive) {
    json["exclusive"][group.name] = node_names(graph, group.nodes);
  }
  json["objective"] = Json::array();
  for (const graph::Term& term : app.objective) json["objective"].push_back(term_json(graph, term));
  json["order"] = subchain_names(graph, app.order);
  json["steal"] = {{"priority", subchain_names(graph, app.steal.priority)},
                   {"off", subchain_names(graph, app.steal.off)}};
  json["scheduler"] = scheduler_json(app.scheduler);
  return json.dump(1) + "\n";
}

}  // namespace ctn::tool
