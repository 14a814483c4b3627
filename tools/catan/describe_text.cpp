#include <fmt/format.h>

#include <algorithm>

#include "config/quantity.h"
#include "describe.h"
#include "table.h"

namespace ctn::tool {
namespace {

using graph::App;
using graph::Graph;
using graph::Node;

std::string join(const std::vector<std::string>& parts, std::string_view separator = ", ") {
  return fmt::format("{}", fmt::join(parts, separator));
}

std::string names(const Graph& graph, const std::vector<NodeId>& ids) {
  std::vector<std::string> parts;
  for (const NodeId id : ids) parts.push_back(graph.node(id).name);
  return join(parts);
}

std::string names(const Graph& graph, const std::vector<SubchainId>& ids) {
  std::vector<std::string> parts;
  for (const SubchainId id : ids) parts.push_back(graph.subchain(id).name);
  return join(parts);
}

std::string kind(const Graph& graph, const Node& node) {
  if (node.external) return "external";
  if (node.unscheduled) return "unscheduled";
  return "in " + graph.subchain(*node.subchain).name;
}

std::string settings(const Node& node) {
  std::vector<std::string> parts;
  if (node.input == graph::InputKind::kQueue) parts.emplace_back("input queue");
  if (!node.modes.empty()) parts.push_back(fmt::format("modes {}", fmt::join(node.modes, "/")));
  if (node.period) parts.push_back((node.external ? "ticks every " : "every ") + config::format_duration(*node.period));
  if (node.output_period) parts.push_back("emits every " + config::format_duration(*node.output_period));
  if (node.min_rate && node.min_rate == node.max_rate) {
    parts.push_back("exactly " + config::format_rate(*node.min_rate));
  } else {
    if (node.min_rate) parts.push_back("at least " + config::format_rate(*node.min_rate));
    if (node.max_rate) parts.push_back("at most " + config::format_rate(*node.max_rate));
  }
  if (node.trigger != graph::TriggerBy::kAny) parts.push_back(fmt::format("trigger {}", to_string(node.trigger)));
  if (node.max_threads > 1) parts.push_back(fmt::format("up to {} threads", node.max_threads));
  if (node.fallback_rate) parts.push_back("fallback " + config::format_rate(*node.fallback_rate));
  return join(parts);
}

// On each kind of cores.
std::string cost_text(const Graph& graph, const std::vector<model::CostTable>& costs, NodeId node) {
  if (graph.node(node).external) return "";
  std::vector<std::string> parts;
  for (const model::CostTable& table : costs) {
    const Millis per_item = table[node].per_item();
    parts.push_back(fmt::format("{:.6g}ms", table[node].single_thread().count()));
    if (per_item > Millis{0}) parts.back() += fmt::format(" + {:.6g}ms an item", per_item.count());
  }
  return join(parts, " / ");
}

std::string nodes_text(const App& app, const model::CostTable* costs) {
  const Graph& graph = app.graph;
  std::vector<model::CostTable> by_kind;
  if (costs != nullptr) by_kind = model::costs_by_kind(app, *costs);
  Table table({"node", "kind", "inputs", "settings", "cost"});
  for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
    const Node& node = graph.node(NodeId(i));
    table.add({node.name, kind(graph, node), names(graph, node.predecessors), settings(node),
               cost_text(graph, by_kind, NodeId(i))});
  }
  return table.text();
}

std::string cores_text(const App& app) {
  if (app.core_kinds.empty()) return "";
  Table table({"cores", "how many", "speed"});
  for (const graph::CoreKind& kind : app.core_kinds) {
    table.add({kind.name, fmt::format("{}", kind.count), fmt::format("{:.6g}", kind.speed)});
  }
  return "cores\n" + table.text() + "\n";
}

// Within a subchain each run triggers the next; all else is triggered by Catan, by the node that it follows, or by
// itself.
std::string triggers_text(const App& app) {
  Table table({"who triggers", "whom"});
  for (const SubchainId id : app.order) {
    const graph::Subchain& subchain = app.graph.subchain(id);
    table.add({"Catan", app.graph.path_name(subchain.nodes) + (subchain.implicit ? "" : " (" + subchain.name + ")")});
  }
  for (const Node& node : app.graph.nodes()) {
    if (!node.unscheduled) continue;
    table.add({node.follows ? app.graph.node(*node.follows).name : "itself",
               node.name + ", every " + config::format_duration(*node.period)});
  }
  return table.text();
}

std::string age_limits_text(const Graph& graph) {
  Table table({"edge", "data at most", "else"});
  bool any = false;
  for (const graph::Edge& edge : graph.edges()) {
    if (!edge.age_limit) continue;
    any = true;
    table.add({graph.node(edge.from).name + " -> " + graph.node(edge.to).name,
               config::format_duration(edge.age_limit->max_age) + " old",
               edge.age_limit->on_stale == graph::OnStale::kSkip ? "the run gives no output" : "it is told"});
  }
  return any ? "age limits\n" + table.text() + "\n" : "";
}

std::string exclusive_text(const App& app) {
  if (app.exclusive.empty()) return "";
  Table table({"exclusive", "runs of these never overlap"});
  for (const graph::ExclusiveGroup& group : app.exclusive) table.add({group.name, names(app.graph, group.nodes)});
  return "exclusive groups\n" + table.text() + "\n";
}

std::string elements_text(const Graph& graph, const graph::Term& term) {
  std::vector<std::string> parts;
  for (const graph::ChainElement& element : graph.chain_elements(term.path)) {
    parts.push_back(element.subchain ? graph.subchain(*element.subchain).name : graph.node(element.nodes[0]).name);
  }
  return join(parts, " | ");
}

std::string objective_text(const App& app) {
  Table table({"weight", "of", "path", "as scheduled", "max"});
  for (const graph::Term& term : app.objective) {
    table.add({fmt::format("{:.6g}", term.weight), term.metric == graph::Metric::kPeriod ? "period" : "response time",
               app.graph.path_name(term.path), elements_text(app.graph, term),
               term.max ? config::format_duration(*term.max) : ""});
  }
  return table.text();
}

std::string scheduler_text(const App& app) {
  const graph::SchedulerOptions& options = app.scheduler;
  const auto& off = app.steal.off;
  return fmt::format(
      "  slots in order  {}\n"
      "  stealing        {}{}\n"
      "  slack           {}\n"
      "  frames          {}, slices of {} or more\n"
      "  estimates       percentile {:.6g} of the last {} runs; {} until measured, for {}\n"
      "  re-planned      every {}\n",
      names(app.graph, app.order), names(app.graph, app.steal.priority),
      off.empty() ? "" : "; never: " + names(app.graph, off),
      options.slack ? config::format_percentage(*options.slack) : "auto",
      options.frames == graph::FrameMode::kElastic ? "elastic" : "fixed", config::format_duration(options.min_slice),
      options.percentile, options.window, config::format_duration(options.bootstrap_cost),
      config::format_duration(options.bootstrap), config::format_duration(options.replan));
}

// "1 edge", "2 edges".
std::string counted(std::size_t count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

}  // namespace

std::string describe_text(const graph::App& app, const model::CostTable* costs) {
  const Graph& graph = app.graph;
  return fmt::format("{}: {}, {}, {}, {}\n\n{}nodes\n{}\n{}triggers\n{}\n{}objective\n{}\nscheduler\n{}", app.name,
                     counted(graph.nodes().size(), "node"), counted(graph.edges().size(), "edge"),
                     counted(graph.subchains().size(), "subchain"), counted(app.objective.size(), "term"),
                     cores_text(app), nodes_text(app, costs), age_limits_text(graph), triggers_text(app),
                     exclusive_text(app), objective_text(app), scheduler_text(app));
}

}  // namespace ctn::tool
