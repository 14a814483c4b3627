#include "config/cost_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "base/text.h"
#include "config/app_file.h"
#include "config/problems.h"
#include "config/read.h"
#include "config/yaml.h"

namespace ctn::config {
namespace {

constexpr std::array<std::string_view, 3> kCostKeys{"threads", "modes", "kinds"};
constexpr std::string_view kKindsMend = "write it as in {kinds: {big: 1.2ms, little: 3ms}}";
constexpr std::string_view kThreadsMend = "write it as in {threads: {1: 10ms, 2: 6ms}}";
constexpr std::string_view kModesMend = "write it as in {modes: {skip: [0.8, 1.1ms], match: [0.2, 9ms]}}";
constexpr double kSumTolerance = 1e-3;  // probabilities such as 0.333 are rounded

class CostReader {
 public:
  CostReader(const Value& root, const graph::App& app, Problems& problems)
      : root_(root), app_(app), graph_(app.graph), problems_(problems), table_(app.graph, Millis{0}) {}

  model::CostTable read();

 private:
  void read_node(const Entry& entry);
  std::optional<model::CostProfile> read_profile(const Value& value, const graph::Node& node, const std::string& key);
  std::optional<model::CostProfile> read_threads(const Value& value, const graph::Node& node, const std::string& key);
  std::optional<model::CostProfile> read_modes(const Value& value, const graph::Node& node, const std::string& key);
  std::optional<model::ModeCost> read_mode(const Entry& entry, const graph::Node& node, const std::string& key);
  const Value* kinds_of(const Value& value) const;
  void read_kinds(const Value& value, NodeId id, const std::string& key);
  void report_missing_nodes();

  const Value& root_;
  const graph::App& app_;
  const graph::Graph& graph_;
  Problems& problems_;
  model::CostTable table_;
  std::vector<bool> given_;  // by NodeId
};

model::CostTable CostReader::read() {
  given_.assign(graph_.nodes().size(), false);
  if (!expect(root_, ValueKind::kMap, "", "write one line a node, as in LM: 1.2ms", problems_)) return table_;
  for (const Entry* entry : read_entries(root_, "", problems_)) read_node(*entry);
  report_missing_nodes();
  return table_;
}

void CostReader::read_node(const Entry& entry) {
  const std::string key = join_key("", entry.key);
  const auto id = graph_.find_node(entry.key);
  if (!id) {
    std::vector<std::string> names;
    for (const graph::Node& node : graph_.nodes()) names.push_back(node.name);
    const auto meant = nearest(entry.key, names);
    problems_.add(entry.place, key, "the app has no such node",
                  meant ? fmt::format("did you mean {}?", quote(*meant)) : "remove it, or add it to the app file");
    return;
  }
  given_[id->index()] = true;
  const graph::Node& node = graph_.node(*id);
  if (node.external) {
    problems_.add(entry.place, key, "the node is external: it costs this machine nothing", "remove it");
    return;
  }
  if (const Value* kinds = kinds_of(entry.value)) return read_kinds(*kinds, *id, key);
  if (auto profile = read_profile(entry.value, node, key)) table_.set(*id, std::move(*profile));
}

// The value of `kinds` where it is all that a node's entry holds.
const Value* CostReader::kinds_of(const Value& value) const {
  if (value.kind != ValueKind::kMap || value.entries.size() != 1) return nullptr;
  return value.entries.front().key == "kinds" ? &value.entries.front().value : nullptr;
}

// A cost for each kind of cores. On a core of speed 1 the node costs what it does on the first kind, times its speed.
void CostReader::read_kinds(const Value& value, NodeId id, const std::string& node_key) {
  const std::string key = join_key(node_key, "kinds");
  if (!expect(value, ValueKind::kMap, key, kKindsMend, problems_)) return;
  if (app_.core_kinds.empty()) {
    problems_.add(value.place, key, "the app does not say that its cores differ",
                  "give one cost, or add cores: with one entry a kind to the app file");
    return;
  }
  std::vector<std::string> names;
  for (const graph::CoreKind& kind : app_.core_kinds) names.push_back(kind.name);
  std::vector<std::string> missing = names;
  for (const Entry* entry : read_entries(value, key, problems_)) {
    const auto found = std::find(names.begin(), names.end(), entry->key);
    if (found == names.end()) {
      const auto meant = nearest(entry->key, names);
      problems_.add(
          entry->place, join_key(key, entry->key), "the app has no such kind of cores",
          meant ? fmt::format("did you mean {}?", quote(*meant)) : fmt::format("the kinds are {}", quote_list(names)));
      continue;
    }
    std::erase(missing, entry->key);
    const std::string entry_key = join_key(key, entry->key);
    if (const Value* nested = kinds_of(entry->value)) {
      problems_.add(nested->place, join_key(entry_key, "kinds"), "kinds within a kind", "give this kind one cost");
      continue;
    }
    auto profile = read_profile(entry->value, graph_.node(id), entry_key);
    if (!profile) continue;
    const auto kind = static_cast<std::size_t>(found - names.begin());
    if (kind == 0) table_.set(id, profile->times(app_.core_kinds.front().speed));
    table_.set_on(id, kind, std::move(*profile));
  }
  if (missing.empty()) return;
  problems_.add(value.place, key, fmt::format("no cost for {}", quote_list(missing)), "give every kind of cores one");
}

std::optional<model::CostProfile> CostReader::read_profile(const Value& value, const graph::Node& node,
                                                           const std::string& key) {
  if (value.kind == ValueKind::kScalar) {
    const auto cost = read_duration(value, key, problems_);
    if (!cost) return std::nullopt;
    return model::CostProfile::constant(to_millis(cost->value));
  }
  constexpr std::string_view kMend = "write it as in 1.2ms, or {threads: {1: 10ms, 2: 6ms}}";
  if (value.kind != ValueKind::kMap) {
    problems_.add(value.place, key, fmt::format("a duration belongs here, not {}", describe(value)),
                  std::string(kMend));
    return std::nullopt;
  }
  const MapReader map(value, key, kCostKeys, problems_);
  const Value* threads = map.find("threads");
  const Value* modes = map.find("modes");
  if (map.find("kinds") != nullptr) {
    problems_.add(value.place, key, "costs by kind of cores stand alone", "put threads or modes under each kind");
    return std::nullopt;
  }
  if (threads != nullptr && modes != nullptr) {
    problems_.add(value.place, key, "a cost is given by threads or by modes, not both", "keep one of them");
    return std::nullopt;
  }
  if (threads != nullptr) return read_threads(*threads, node, map.key_of("threads"));
  if (modes != nullptr) return read_modes(*modes, node, map.key_of("modes"));
  if (value.entries.empty()) problems_.add(value.place, key, "the cost is missing", std::string(kMend));
  return std::nullopt;
}

std::optional<model::CostProfile> CostReader::read_threads(const Value& value, const graph::Node& node,
                                                           const std::string& key) {
  if (!expect(value, ValueKind::kMap, key, kThreadsMend, problems_)) return std::nullopt;
  std::map<int, Millis> elapsed;
  bool whole = true;
  for (const Entry* entry : read_entries(value, key, problems_)) {
    const std::string entry_key = join_key(key, entry->key);
    const Value number{ValueKind::kScalar, entry->key, false, false, entry->place, {}, {}};
    const auto threads = read_int(number, entry_key, 1, node.max_threads, problems_);
    const auto cost = read_duration(entry->value, entry_key, problems_);
    whole = whole && threads && cost;
    if (!threads || !cost) continue;
    if (!elapsed.try_emplace(threads->value, to_millis(cost->value)).second) {
      problems_.add(entry->place, entry_key, fmt::format("the time with {} threads was given before", threads->value),
                    "keep one of them");
    }
  }
  if (!whole) return std::nullopt;
  if (!elapsed.contains(1)) {
    problems_.add(value.place, key, "the time with 1 thread is missing", "add 1: with the time that one thread takes");
    return std::nullopt;
  }
  return model::CostProfile::of_threads(std::move(elapsed));
}

std::optional<model::CostProfile> CostReader::read_modes(const Value& value, const graph::Node& node,
                                                         const std::string& key) {
  if (!expect(value, ValueKind::kMap, key, kModesMend, problems_)) return std::nullopt;
  if (node.modes.empty()) {
    problems_.add(value.place, key, "the app declares no modes for this node",
                  fmt::format("write {}: with one duration, or add modes to the node in the app file", node.name));
    return std::nullopt;
  }
  std::vector<model::ModeCost> costs;
  std::vector<std::string> missing = node.modes;
  bool whole = true;
  double sum = 0.0;
  for (const Entry* entry : read_entries(value, key, problems_)) {
    std::erase(missing, entry->key);
    auto cost = read_mode(*entry, node, join_key(key, entry->key));
    whole = whole && cost;
    if (!cost) continue;
    sum += cost->probability;
    costs.push_back(std::move(*cost));
  }
  if (!missing.empty()) {
    problems_.add(value.place, key, fmt::format("no cost for mode {}", quote_list(missing)),
                  "give every mode that the app declares, with probability 0 if it never happens");
    return std::nullopt;
  }
  if (!whole || costs.size() < value.entries.size()) return std::nullopt;  // a doubled mode was reported
  if (std::abs(sum - 1.0) > kSumTolerance) {
    problems_.add(value.place, key, fmt::format("the probabilities add up to {:.4g}", sum), "make them add up to 1");
    return std::nullopt;
  }
  for (model::ModeCost& cost : costs) cost.probability /= sum;
  return model::CostProfile::of_modes(std::move(costs));
}

std::optional<model::ModeCost> CostReader::read_mode(const Entry& entry, const graph::Node& node,
                                                     const std::string& key) {
  bool good = true;
  if (std::find(node.modes.begin(), node.modes.end(), entry.key) == node.modes.end()) {
    const auto meant = nearest(entry.key, node.modes);
    problems_.add(entry.place, key, "the app declares no such mode",
                  meant ? fmt::format("did you mean {}?", quote(*meant))
                        : fmt::format("the modes are {}", quote_list(node.modes)));
    good = false;
  }
  constexpr std::string_view kMend = "write [probability, duration], as in [0.8, 1.1ms]";
  if (!expect(entry.value, ValueKind::kSequence, key, kMend, problems_)) return std::nullopt;
  if (entry.value.items.size() != 2) {
    problems_.add(entry.value.place, key, fmt::format("a list of {} values", entry.value.items.size()),
                  std::string(kMend));
    return std::nullopt;
  }
  const auto probability = read_number(entry.value.items[0], key + "[0]", problems_);
  const auto cost = read_duration(entry.value.items[1], key + "[1]", problems_);
  if (probability && (probability->value < 0.0 || probability->value > 1.0)) {
    problems_.add(probability->place, key + "[0]", fmt::format("{} is no probability", describe(entry.value.items[0])),
                  "write a number from 0 to 1");
    good = false;
  }
  if (!good || !probability || !cost) return std::nullopt;
  return model::ModeCost{entry.key, probability->value, to_millis(cost->value)};
}

void CostReader::report_missing_nodes() {
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const graph::Node& node = graph_.node(NodeId(i));
    if (!given_[i] && !node.external && !node.unscheduled) missing.push_back(node.name);
  }
  if (missing.empty()) return;
  problems_.add(root_.place, "", fmt::format("no cost for {}", quote_list(missing)),
                fmt::format("add one line a node, as in {}: 1.2ms", missing.front()));
}

}  // namespace

Result<model::CostTable> parse_costs(std::string_view text, std::string_view file, const graph::App& app) {
  const auto root = parse_yaml(text, file, "docs/cost-file.md");
  if (!root) return root.error();
  Problems problems;
  model::CostTable table = CostReader(*root, app, problems).read();
  if (!problems.empty()) return std::move(problems).to_error();
  return table;
}

Result<model::CostTable> load_costs(const std::string& path, const graph::App& app) {
  const auto text = read_text(path);
  if (!text) return text.error();
  return parse_costs(*text, path, app);
}

}  // namespace ctn::config
