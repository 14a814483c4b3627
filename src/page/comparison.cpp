#include "page/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "base/text.h"

namespace ctn::page {
namespace {

using Names = std::set<std::string>;

struct Parts {
  Names nodes;
  Names edges;
  Names subchains;
  Names responses;
};

Parts parts_of(const graph::App& app) {
  Parts parts;
  for (const graph::Node& node : app.graph.nodes()) parts.nodes.insert(node.name);
  for (const graph::Edge& edge : app.graph.edges()) {
    parts.edges.insert(app.graph.node(edge.from).name + " -> " + app.graph.node(edge.to).name);
  }
  for (const graph::Subchain& subchain : app.graph.subchains()) {
    parts.subchains.insert(subchain.name + " (" + app.graph.path_name(subchain.nodes) + ")");
  }
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kResponseTime) parts.responses.insert(app.graph.path_name(term.path));
  }
  return parts;
}

void add_missing(std::vector<std::string>& differences, const char* what, const Names& names, const Names& others,
                 const std::string& record) {
  std::vector<std::string> only;
  std::set_difference(names.begin(), names.end(), others.begin(), others.end(), std::back_inserter(only));
  if (!only.empty()) differences.push_back(fmt::format("Only {} has the {} {}", record, what, quote_list(only)));
}

std::string figure(double value) { return fmt::format("{:.4g}", value); }

std::string difference(double one, double two) {
  if (one <= 0.0) return "-";
  const double percent = 100.0 * (two - one) / one;
  return fmt::format("{:+.{}f}\u00a0%", percent, std::abs(percent) < 100.0 ? 1 : 0);
}

// "12.5 / 10 (-20.0 %)", of both runs in one cell, so that a table has no more columns than that of one run. Its line
// breaks in front of the bracket at most.
std::string side_by_side(double one, double two) {
  return fmt::format("{}\u00a0/\u00a0{} ({})", figure(one), figure(two), difference(one, two));
}

// Nothing where one of the runs has no samples. `name` is in the first of its rows alone, and is empty from then on.
void add_row(report::Table& table, std::string& name, const std::string& metric, const Summary& run,
             const Summary& other) {
  if (run.count == 0 || other.count == 0) return;
  std::vector<std::string> row{std::exchange(name, ""), metric};
  for (const double Summary::*value : {&Summary::mean, &Summary::p95, &Summary::p99, &Summary::max}) {
    row.push_back(side_by_side(run.*value, other.*value));
  }
  table.rows.push_back(std::move(row));
}

}  // namespace

Result<std::vector<std::string>> differences_of(const graph::App& app, const std::string& name, const graph::App& other,
                                                const std::string& other_name) {
  const Parts one = parts_of(app);
  const Parts two = parts_of(other);
  Names common;
  std::set_intersection(one.nodes.begin(), one.nodes.end(), two.nodes.begin(), two.nodes.end(),
                        std::inserter(common, common.begin()));
  if (common.empty()) {
    return Error::caller(fmt::format("{} is a run of '{}' and {} of '{}', which have no node in common", name, app.name,
                                     other_name, other.name),
                         "compare two runs of one app, or of two versions of it");
  }
  std::vector<std::string> differences;
  const auto both = [&](const char* what, const Names Parts::*names) {
    add_missing(differences, what, one.*names, two.*names, name);
    add_missing(differences, what, two.*names, one.*names, other_name);
  };
  both("nodes", &Parts::nodes);
  both("edges", &Parts::edges);
  both("subchains", &Parts::subchains);
  both("response times", &Parts::responses);
  if (!differences.empty()) differences.emplace_back("The apps differ: what both have is compared.");
  return differences;
}

std::optional<std::size_t> find_chain(const report::RunFigures& figures, const std::string& path) {
  for (std::size_t i = 0; i < figures.chains.size(); ++i) {
    if (figures.chains[i].path == path) return i;
  }
  return std::nullopt;
}

std::vector<report::Table> comparison_tables(const report::RunFigures& run, const std::string& name,
                                             const report::RunFigures& other, const std::string& other_name) {
  const std::string which = fmt::format("a is {}, b is {}", name, other_name);
  const std::vector<std::string> columns{"mean: a / b", "p95: a / b", "p99: a / b", "max: a / b"};
  report::Table chains{.header = {"chain", "in ms"}, .caption = "Chains: " + which};
  chains.header.insert(chains.header.end(), columns.begin(), columns.end());
  for (const report::ChainMetrics& chain : run.chains) {
    const auto index = find_chain(other, chain.path);
    if (!index) continue;
    std::string path = chain.path;
    add_row(chains, path, "response time", chain.response_ms, other.chains[*index].response_ms);
    add_row(chains, path, "latency", chain.latency_ms, other.chains[*index].latency_ms);
    add_row(chains, path, "period", chain.period_ms, other.chains[*index].period_ms);
  }
  report::Table nodes{.header = {"node", "in ms"}, .caption = "Nodes: " + which};
  nodes.header.insert(nodes.header.end(), columns.begin(), columns.end());
  for (const report::NodeMetrics& node : run.nodes) {
    const auto same = std::find_if(other.nodes.begin(), other.nodes.end(),
                                   [&](const report::NodeMetrics& one) { return one.name == node.name; });
    if (same == other.nodes.end()) continue;
    std::string node_name = node.name;
    add_row(nodes, node_name, "compute time", node.compute_ms, same->compute_ms);
    add_row(nodes, node_name, "period", node.period_ms, same->period_ms);
  }
  report::Table whole{.header = {"", "a / b"}, .caption = "In all: " + which};
  const auto row = [&](const char* what, std::optional<double> one, std::optional<double> two) {
    if (one && two) whole.rows.push_back({what, side_by_side(*one, *two)});
  };
  row("objective, measured", run.objective.measured, other.objective.measured);
  row("objective, predicted", run.objective.predicted, other.objective.predicted);
  row("cores used", run.cores_used, other.cores_used);
  std::vector<report::Table> tables;
  for (report::Table& table : std::vector<report::Table>{whole, chains, nodes}) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace ctn::page
