// Nodes: names, kinds, and which keys a kind may have.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "base/text.h"
#include "graph/app_builder.h"

namespace ctn::graph {
namespace {

constexpr std::size_t kLongestName = 100;

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
         c == '.' || c == '/';
}

Node to_node(const NodeSpec& spec) {
  Node node;
  node.name = spec.name.value;
  node.input = spec.input;
  for (const Name& mode : spec.modes) node.modes.push_back(mode.value);
  node.external = spec.external;
  node.unscheduled = spec.unscheduled && !spec.external;
  if (spec.period) node.period = spec.period->value;
  if (spec.output_period) node.output_period = spec.output_period->value;
  if (spec.min_rate) node.min_rate = spec.min_rate->value;
  if (spec.max_rate) node.max_rate = spec.max_rate->value;
  if (spec.fallback_rate) node.fallback_rate = spec.fallback_rate->value;
  if (spec.max_threads) node.max_threads = spec.max_threads->value;
  if (spec.trigger) node.trigger = spec.trigger->value;
  node.needs_input = spec.needs_input && !spec.external;
  return node;
}

}  // namespace

bool AppBuilder::is_name(const Name& name) {
  return !name.value.empty() && name.value.size() <= kLongestName &&
         std::all_of(name.value.begin(), name.value.end(), is_name_character);
}

bool AppBuilder::check_name(const Name& name, const std::string& key, std::string_view of_what) {
  if (name.value.empty()) {
    problem(name.place, key, fmt::format("the name of this {} is empty", of_what), "give it a name");
    return false;
  }
  if (name.value.size() > kLongestName) {
    problem(name.place, key, fmt::format("the name is {} characters long", name.value.size()),
            fmt::format("use at most {}", kLongestName));
    return false;
  }
  if (!is_name(name)) {
    problem(name.place, key, fmt::format("{} is no name for this {}", quote(name.value), of_what),
            "use letters, digits, '_', '-', '.' and '/'");
    return false;
  }
  return true;
}

void AppBuilder::add_nodes() {
  if (spec_.nodes.empty()) problem(spec_.name.place, "nodes", "the app has no nodes", "name every node under nodes");
  for (std::size_t i = 0; i < spec_.nodes.size(); ++i) {
    const NodeSpec& spec = spec_.nodes[i];
    const std::string key = is_name(spec.name) ? "nodes." + spec.name.value : fmt::format("nodes[{}]", i);
    if (!check_name(spec.name, key, "node") && spec.name.value.empty()) continue;
    if (node_index_.contains(spec.name.value)) {
      problem(spec.name.place, key, fmt::format("there are two nodes {}", quote(spec.name.value)),
              "rename or remove one");
      continue;
    }
    node_index_.emplace(spec.name.value, NodeId(node_specs_.size()));
    node_specs_.push_back(&spec);
    node_names_.push_back(spec.name.value);
    app_.graph.nodes_.push_back(to_node(spec));
    check_kind(spec, key);
    check_values(spec, key);
    check_modes(spec, key);
  }
}

// Which keys make sense depends on what runs the node: Catan, the node itself, or something outside.
void AppBuilder::check_kind(const NodeSpec& spec, const std::string& key) {
  if (spec.external && spec.unscheduled) {
    problem(spec.name.place, key, "the node is both external and unscheduled",
            "keep external if another program or hardware runs it, else unscheduled");
    return;
  }
  const auto reject = [&](const auto& value, std::string_view name, std::string_view why) {
    if (value) problem(value->place, fmt::format("{}.{}", key, name), std::string(why), fmt::format("remove {}", name));
  };
  if (spec.external) {
    constexpr std::string_view kWhy = "an external node runs elsewhere: Catan neither times nor triggers it";
    reject(spec.output_period, "output_period", kWhy);
    if (!spec.modes.empty()) problem(spec.modes.front().place, key + ".modes", std::string(kWhy), "remove modes");
    if (spec.input == InputKind::kQueue) problem(spec.name.place, key + ".input", std::string(kWhy), "remove input");
  }
  if (spec.external || spec.unscheduled) {
    const std::string_view why = spec.external
                                     ? "an external node runs elsewhere: Catan neither times nor triggers it"
                                     : "an unscheduled node runs by itself: Catan does not set its rate or cores";
    reject(spec.min_rate, "min_rate", why);
    reject(spec.max_rate, "max_rate", why);
    reject(spec.fallback_rate, "fallback_rate", why);
    reject(spec.max_threads, "max_threads", why);
    reject(spec.trigger, "trigger", why);
  } else if (spec.period) {
    problem(spec.period->place, key + ".period",
            "period is for unscheduled and external nodes; Catan chooses that of this one",
            "add unscheduled: true if it runs by itself, or bound it by min_rate and max_rate");
  }
}

void AppBuilder::check_values(const NodeSpec& spec, const std::string& key) {
  const auto positive = [&](const std::optional<At<Nanos>>& value, std::string_view name) {
    if (value && value->value <= Nanos::zero()) {
      problem(value->place, fmt::format("{}.{}", key, name), fmt::format("{} must be more than 0", name),
              fmt::format("write {}: 20ms, say, or remove it", name));
    }
  };
  positive(spec.period, "period");
  positive(spec.output_period, "output_period");
  if (spec.max_threads && (spec.max_threads->value < 1 || spec.max_threads->value > kMaxThreads)) {
    problem(spec.max_threads->place, key + ".max_threads",
            fmt::format("{} threads are out of range", spec.max_threads->value),
            fmt::format("write a whole number from 1 to {}", kMaxThreads));
  }
  if (spec.min_rate && spec.min_rate->value > kHighestTriggerRate) {
    problem(spec.min_rate->place, key + ".min_rate",
            fmt::format("{}Hz cannot be had: nothing is triggered more often than {}Hz", spec.min_rate->value.hertz(),
                        kHighestTriggerRate.hertz()),
            "ask for less");
  }
  if (spec.min_rate && spec.max_rate && spec.min_rate->value > spec.max_rate->value) {
    problem(spec.min_rate->place, key + ".min_rate",
            fmt::format("min_rate ({}Hz) is above max_rate ({}Hz)", spec.min_rate->value.hertz(),
                        spec.max_rate->value.hertz()),
            "swap them, or make them equal for an exact rate");
  }
}

void AppBuilder::check_modes(const NodeSpec& spec, const std::string& key) {
  std::set<std::string_view> seen;
  for (std::size_t i = 0; i < spec.modes.size(); ++i) {
    const Name& mode = spec.modes[i];
    const std::string mode_key = fmt::format("{}.modes[{}]", key, i);
    if (!check_name(mode, mode_key, "mode")) continue;
    if (!seen.insert(mode.value).second) {
      problem(mode.place, mode_key, fmt::format("mode {} is named twice", quote(mode.value)), "remove one");
    }
  }
}

}  // namespace ctn::graph
