// Subchains: written ones, implicit ones, and the rates that their nodes must agree on. And exclusive groups.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "base/text.h"
#include "graph/app_builder.h"
#include "graph/rules.h"

namespace ctn::graph {

void AppBuilder::add_subchains() {
  for (std::size_t i = 0; i < spec_.subchains.size(); ++i) {
    const SubchainSpec& spec = spec_.subchains[i];
    const std::string key = is_name(spec.name) ? "subchains." + spec.name.value : fmt::format("subchains[{}]", i);
    check_name(spec.name, key, "subchain");
    const SubchainId id(app_.graph.subchains_.size());
    const bool fresh = subchain_index_.try_emplace(spec.name.value, id).second;
    if (!fresh) {
      problem(spec.name.place, key, fmt::format("there are two subchains {}", quote(spec.name.value)),
              "rename or remove one");
    }
    if (spec.nodes.empty()) problem(spec.name.place, key, "the subchain has no nodes", "name its nodes, or remove it");
    app_.graph.subchains_.push_back({spec.name.value, {}, false});
    subchain_names_.push_back(spec.name.value);
    bool whole = true;
    for (const Name& name : spec.nodes) whole = add_member(id, name, key) && whole;
    if (whole) check_subchain_path(spec, key);
  }
  add_implicit_subchains();
  for (const Subchain& subchain : app_.graph.subchains_) {
    check_rates(subchain);
    check_fallback_rates(subchain);
    check_triggers(subchain);
  }
}

bool AppBuilder::add_member(SubchainId id, const Name& name, const std::string& key) {
  const auto resolved = resolve_node(name, key);
  if (!resolved) return false;
  Node& node = app_.graph.nodes_[resolved->index()];
  if (node.external || node.unscheduled) {
    problem(name.place, key,
            fmt::format("node {} is {}, so it can be in no subchain", quote(node.name),
                        node.external ? "external" : "unscheduled"),
            fmt::format("leave it out, or make it a scheduled node in nodes.{}", node.name));
    return false;
  }
  if (node.subchain == id) {
    problem(name.place, key, fmt::format("node {} is named twice", quote(node.name)), "name it once");
    return false;
  }
  if (node.subchain) {
    problem(
        name.place, key,
        fmt::format("node {} is in subchain {} too", quote(node.name), quote(app_.graph.subchain(*node.subchain).name)),
        "keep it in one of them");
    return false;
  }
  node.subchain = id;
  app_.graph.subchains_[id.index()].nodes.push_back(*resolved);
  return true;
}

void AppBuilder::check_subchain_path(const SubchainSpec& spec, const std::string& key) {
  for (std::size_t i = 1; i < spec.nodes.size(); ++i) {
    const Name& from = spec.nodes[i - 1];
    const Name& to = spec.nodes[i];
    const NodeId from_id = node_index_.at(from.value);
    const NodeId to_id = node_index_.at(to.value);
    if (!lacks_edge(from_id, to_id)) continue;
    problem(to.place, key, fmt::format("no edge leads from {} to {}", quote(from.value), quote(to.value)),
            has_edge(to_id, from_id)
                ? fmt::format("write {} before {}: the edge leads that way", to.value, from.value)
                : fmt::format("add {} -> {} to edges, or split the subchain", from.value, to.value));
  }
}

void AppBuilder::add_implicit_subchains() {
  for (std::size_t i = 0; i < app_.graph.nodes_.size(); ++i) {
    Node& node = app_.graph.nodes_[i];
    if (node.external || node.unscheduled || node.subchain) continue;
    const SubchainId id(app_.graph.subchains_.size());
    const auto [taken, fresh] = subchain_index_.try_emplace(node_specs_[i]->name.value, id);
    if (!fresh) {
      const SubchainSpec& other = spec_.subchains[taken->second.index()];
      problem(other.name.place, "subchains." + other.name.value,
              fmt::format("node {} is a subchain of that name already, as no subchain names it", quote(node.name)),
              fmt::format("rename this subchain, or add {} to it", node.name));
    }
    node.subchain = id;
    app_.graph.subchains_.push_back({node.name, {NodeId(i)}, true});
    subchain_names_.push_back(node.name);
  }
  if (app_.graph.subchains_.empty() && !app_.graph.nodes_.empty()) {
    problem(spec_.nodes.front().name.place, "nodes", "every node is external or unscheduled: nothing to schedule",
            "leave external and unscheduled out for those that Catan is to run");
  }
}

// All nodes of a subchain run at one rate, so that the highest min_rate and the lowest max_rate of them must agree.
void AppBuilder::check_rates(const Subchain& subchain) {
  const NodeSpec* highest_min = nullptr;
  const NodeSpec* lowest_max = nullptr;
  for (const NodeId id : subchain.nodes) {
    const NodeSpec* spec = node_specs_[id.index()];
    if (spec->min_rate && (!highest_min || spec->min_rate->value > highest_min->min_rate->value)) highest_min = spec;
    if (spec->max_rate && (!lowest_max || spec->max_rate->value < lowest_max->max_rate->value)) lowest_max = spec;
    if (spec->min_rate) {
      problem(spec->min_rate->place, rate_above_outputs(app_.graph, id, spec->min_rate->value,
                                                        "lower it, or output_period of the node before"));
    }
  }
  // Within one node it was reported there.
  if (!highest_min || !lowest_max || highest_min == lowest_max) return;
  if (highest_min->min_rate->value <= lowest_max->max_rate->value) return;
  problem(highest_min->min_rate->place, fmt::format("nodes.{}.min_rate", highest_min->name.value),
          fmt::format("{}Hz is above the max_rate of {} ({}Hz), and both run at the rate of subchain {}",
                      highest_min->min_rate->value.hertz(), quote(lowest_max->name.value),
                      lowest_max->max_rate->value.hertz(), quote(subchain.name)),
          "lower one, raise the other, or split the subchain");
}

// Each such rate is that of the nodes from its own on, up to the next that has one (cut.h).
void AppBuilder::check_fallback_rates(const Subchain& subchain) {
  const NodeSpec* sets_rate = nullptr;
  for (const NodeId id : subchain.nodes) {
    const NodeSpec& spec = *node_specs_[id.index()];
    if (spec.fallback_rate) {
      sets_rate = &spec;
      if (id != subchain.head()) check_name_of_part(spec);
    }
    if (sets_rate != nullptr && spec.max_rate && sets_rate->fallback_rate->value > spec.max_rate->value) {
      report_fallback_above_max(*sets_rate, spec);
    }
  }
}

// Where rates are set by hand, the node begins a subchain under its own name.
void AppBuilder::check_name_of_part(const NodeSpec& spec) {
  const auto taken = subchain_index_.find(spec.name.value);
  if (taken == subchain_index_.end()) return;
  problem(spec.fallback_rate->place, fmt::format("nodes.{}.fallback_rate", spec.name.value),
          fmt::format("with a rate of its own, {0} begins a subchain {0} where rates are set by hand, but there is one "
                      "of that name",
                      quote(spec.name.value)),
          fmt::format("rename subchains.{}", spec.name.value));
}

void AppBuilder::report_fallback_above_max(const NodeSpec& sets_rate, const NodeSpec& bounded) {
  const double rate = sets_rate.fallback_rate->value.hertz();
  const double max = bounded.max_rate->value.hertz();
  const bool own = &sets_rate == &bounded;
  problem(sets_rate.fallback_rate->place, fmt::format("nodes.{}.fallback_rate", sets_rate.name.value),
          own ? fmt::format("fallback_rate ({}Hz) is above max_rate ({}Hz)", rate, max)
              : fmt::format("fallback_rate ({}Hz) is above the max_rate of {} ({}Hz), which runs at it", rate,
                            quote(bounded.name.value), max),
          own ? std::string("lower it, or raise max_rate")
              : fmt::format("lower it, raise that max_rate, or give {} a fallback_rate, too", bounded.name.value));
}

void AppBuilder::check_triggers(const Subchain& subchain) {
  for (const NodeId id : subchain.nodes) {
    const NodeSpec& spec = *node_specs_[id.index()];
    if (!spec.trigger) continue;
    const std::string key = fmt::format("nodes.{}.trigger", spec.name.value);
    if (id != subchain.head()) {
      problem(spec.trigger->place, key,
              fmt::format("only the head of a subchain is triggered by Catan; {} runs with {} in subchain {}",
                          quote(spec.name.value), quote(name_of(subchain.head())), quote(subchain.name)),
              fmt::format("move it to nodes.{}", name_of(subchain.head())));
      continue;
    }
    if (spec.trigger->value != TriggerBy::kArrival) continue;
    const auto& inputs = app_.graph.node(id).predecessors;
    if (std::none_of(inputs.begin(), inputs.end(), [&](NodeId input) { return app_.graph.node(input).unscheduled; })) {
      problem(
          spec.trigger->place, key,
          fmt::format("no unscheduled node feeds {}: nothing arrives that could trigger it", quote(spec.name.value)),
          "add an edge from one, or write trigger: any");
    }
    problem(spec.trigger->place,
            exact_rate_by_arrival(key, app_.graph, subchain, "remove trigger, or make min_rate and max_rate differ"));
  }
}

void AppBuilder::add_exclusive_groups() {
  std::set<std::string_view> seen;
  for (std::size_t i = 0; i < spec_.exclusive.size(); ++i) {
    const ExclusiveGroupSpec& spec = spec_.exclusive[i];
    const std::string key = is_name(spec.name) ? "exclusive." + spec.name.value : fmt::format("exclusive[{}]", i);
    if (check_name(spec.name, key, "exclusive group") && !seen.insert(spec.name.value).second) {
      problem(spec.name.place, key, fmt::format("there are two exclusive groups {}", quote(spec.name.value)),
              "rename or remove one");
    }
    if (spec.nodes.size() < 2) {
      problem(spec.name.place, key, "an exclusive group needs two nodes or more: a node's own runs never overlap",
              "name the nodes whose runs do not overlap, or remove it");
    }
    app_.exclusive.push_back({spec.name.value, {}});
    for (const Name& name : spec.nodes) {
      if (add_exclusive(i, name, key)) app_.exclusive.back().nodes.push_back(node_index_.at(name.value));
    }
  }
}

bool AppBuilder::add_exclusive(std::size_t group, const Name& name, const std::string& key) {
  const auto resolved = resolve_node(name, key);
  if (!resolved) return false;
  Node& node = app_.graph.nodes_[resolved->index()];
  if (node.external) {
    problem(name.place, key, fmt::format("node {} is external: nothing is known of its runs", quote(node.name)),
            "leave it out");
    return false;
  }
  if (node.exclusive == group) {
    problem(name.place, key, fmt::format("node {} is named twice", quote(node.name)), "name it once");
    return false;
  }
  if (node.exclusive) {
    problem(name.place, key,
            fmt::format("node {} is in exclusive group {} too", quote(node.name),
                        quote(app_.exclusive[*node.exclusive].name)),
            "keep it in one of them, or make one group of both");
    return false;
  }
  node.exclusive = group;
  return true;
}

}  // namespace ctn::graph
