// The objective, and the rankings of subchains that default to it (ranking.h).
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/text.h"
#include "graph/app_builder.h"
#include "graph/ranking.h"
#include "graph/rules.h"

namespace ctn::graph {

void AppBuilder::add_objective() {
  if (spec_.objective.empty()) {
    problem(spec_.name.place, "objective", "the app has no objective, so that no plan is better than another",
            "add a response_time or a period with its weight");
  }
  std::map<std::pair<Metric, std::vector<NodeId>>, std::size_t> seen;
  for (std::size_t i = 0; i < spec_.objective.size(); ++i) {
    const TermSpec& spec = spec_.objective[i];
    const std::string key = fmt::format("objective[{}]", i);
    auto term = resolve_term(spec, key);
    if (!term) continue;
    const auto [other, fresh] = seen.try_emplace({term->metric, term->path}, i);
    if (!fresh) {
      problem(spec.place, key, fmt::format("objective[{}] is about the same", other->second),
              "keep one, with the sum of the weights");
    }
    app_.objective.push_back(std::move(*term));
  }
  std::vector<double> weights;
  for (const TermSpec& spec : spec_.objective) weights.push_back(spec.weight.value);
  if (const auto wrong = wrong_sum_of_weights(weights)) {
    problem(spec_.objective[wrong->term].weight.place, wrong->problem);
  }
}

std::optional<Term> AppBuilder::resolve_term(const TermSpec& spec, const std::string& key) {
  problem(spec.weight.place, wrong_weight(key + ".weight", spec.weight.value));
  if (spec.max && spec.metric == Metric::kPeriod) {
    problem(spec.max->place, key + ".max", "max bounds a response time; a period is bounded by a rate",
            spec.path.size() == 1 && spec.max->value > Nanos::zero()
                ? fmt::format("write min_rate: {:.6g}Hz in nodes.{}",
                              1e9 / static_cast<double>(spec.max->value.count()), spec.path.front().value)
                : "write min_rate in nodes");
  } else if (spec.max && spec.max->value <= Nanos::zero()) {
    problem(spec.max->place, key + ".max", "max must be more than 0", "write max: 60ms, say, or remove it");
  }
  const std::string path_key = key + (spec.metric == Metric::kPeriod ? ".period" : ".response_time");
  std::vector<NodeId> path;
  for (const Name& name : spec.path) {
    if (const auto id = resolve_node(name, path_key)) path.push_back(*id);
  }
  if (path.size() < spec.path.size() || !check_term_path(spec, path, path_key)) return std::nullopt;
  Term term{spec.metric, std::move(path), spec.weight.value, std::nullopt};
  if (spec.max) term.max = spec.max->value;
  return term;
}

bool AppBuilder::check_term_path(const TermSpec& spec, const std::vector<NodeId>& path, const std::string& key) {
  const auto node = [&](NodeId id) -> const Node& { return app_.graph.node(id); };
  if (spec.metric == Metric::kPeriod) {
    if (path.size() != 1) {
      problem(spec.place, key, "a period is that of one node", "name one node");
      return false;
    }
    if (!node(path[0]).external && !node(path[0]).unscheduled) return true;
    problem(spec.path[0].place, key,
            fmt::format("node {} is {}: its period is not Catan's to choose", quote(node(path[0]).name),
                        node(path[0]).external ? "external" : "unscheduled"),
            "name a scheduled node, or remove this term");
    return false;
  }
  if (path.empty()) {
    problem(spec.place, key, "the path has no nodes", "write it as in [scan, LM]");
    return false;
  }
  bool connected = true;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (has_edge(path[i - 1], path[i])) continue;
    connected = false;
    if (!lacks_edge(path[i - 1], path[i])) continue;
    problem(spec.path[i].place, key,
            fmt::format("no edge leads from {} to {}", quote(name_of(path[i - 1])), quote(name_of(path[i]))),
            fmt::format("add {} -> {} to edges, or correct the path", name_of(path[i - 1]), name_of(path[i])));
  }
  if (std::all_of(path.begin(), path.end(), [&](NodeId id) { return node(id).external; })) {
    problem(spec.place, key, "every node of the path is external: Catan can do nothing about it",
            "name a path through a node that Catan runs, or remove this term");
    return false;
  }
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    if (!node(path[i]).is_external_clock()) continue;
    problem(spec.path[i].place, key,
            fmt::format("external node {} has a period, and so a clock, which counts only where a path begins or ends",
                        quote(name_of(path[i]))),
            fmt::format("end the path at {}, or remove its period", name_of(path[i])));
    return false;
  }
  return connected;
}

void AppBuilder::add_order() {
  app_.order = spec_.order ? resolve_ranking(*spec_.order, "order") : ordered_by_data_flow(app_);
  app_.steal.priority =
      spec_.steal_priority ? resolve_ranking(*spec_.steal_priority, "steal.priority") : ranked_by_weight(app_);
  std::vector<bool> seen(subchain_names_.size(), false);
  for (std::size_t i = 0; i < spec_.steal_off.size(); ++i) {
    const Name& name = spec_.steal_off[i];
    const std::string key = fmt::format("steal.off[{}]", i);
    const auto id = resolve_subchain(name, key);
    if (!id) continue;
    if (seen[id->index()]) {
      problem(name.place, key, fmt::format("subchain {} is named twice", quote(name.value)), "name it once");
      continue;
    }
    seen[id->index()] = true;
    app_.steal.off.push_back(*id);
  }
}

std::vector<SubchainId> AppBuilder::resolve_ranking(const std::vector<Name>& names, const std::string& key) {
  std::vector<SubchainId> ranking;
  std::vector<bool> seen(subchain_names_.size(), false);
  bool resolved = true;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto id = resolve_subchain(names[i], fmt::format("{}[{}]", key, i));
    resolved = resolved && id;
    if (!id) continue;
    if (seen[id->index()]) {
      problem(names[i].place, fmt::format("{}[{}]", key, i),
              fmt::format("subchain {} is named twice", quote(names[i].value)), "name it once");
      continue;
    }
    seen[id->index()] = true;
    ranking.push_back(*id);
  }
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const bool reachable = subchain_index_.at(subchain_names_[i]) == SubchainId(i);  // else a doubled name
    if (!seen[i] && reachable) missing.push_back(subchain_names_[i]);
  }
  // A misspelt name is most likely the missing one: said once is enough.
  if (!missing.empty() && resolved) {
    problem(names.empty() ? spec_.name.place : names.front().place, key,
            fmt::format("{} {} not ranked", quote_list(missing), missing.size() == 1 ? "is" : "are"),
            fmt::format("name every subchain once, or leave {} out: the default is by weight", key));
  }
  return ranking;
}

std::optional<SubchainId> AppBuilder::resolve_subchain(const Name& name, const std::string& key) {
  if (const auto found = subchain_index_.find(name.value); found != subchain_index_.end()) return found->second;
  const auto node = node_index_.find(name.value);
  if (node == node_index_.end()) {
    problem(name.place, key, fmt::format("there is no subchain {}", quote(name.value)),
            guess(name.value, subchain_names_, "name a subchain, or a node that no subchain names"));
  } else if (const auto owner = app_.graph.node(node->second).subchain) {
    const std::string& owner_name = app_.graph.subchain(*owner).name;
    problem(name.place, key, fmt::format("node {} is part of subchain {}", quote(name.value), quote(owner_name)),
            fmt::format("write {}", owner_name));
  } else {
    problem(name.place, key, fmt::format("node {} is in no subchain: Catan does not schedule it", quote(name.value)),
            "remove it here");
  }
  return std::nullopt;
}

}  // namespace ctn::graph
