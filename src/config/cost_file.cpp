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
#include "config/quantity.h"
#include "config/read.h"
#include "config/yaml.h"

namespace ctn::config {
namespace {

constexpr std::array<std::string_view, 9> kCostKeys{"cost", "typical", "threads", "modes",   "kinds",
                                                    "grow", "spikes",  "wait",    "per_item"};
constexpr std::array<std::string_view, 2> kKindsKeys{"kinds", "wait"};
constexpr std::string_view kKindsHint = "write it as in {kinds: {big: 1.2ms, little: 3ms}}";
constexpr std::string_view kCostHint = "write it as in 1.2ms, or {threads: {1: 10ms, 2: 6ms}}";
constexpr std::string_view kThreadsHint = "write it as in {threads: {1: 10ms, 2: 6ms}}";
constexpr std::string_view kModesHint = "write it as in {modes: {skip: [0.8, 1.1ms], match: [0.2, 9ms]}}";
constexpr std::string_view kWaitHint = "write a duration, as in 4ms, or [duration, typical], as in [4ms, 3ms]";
constexpr std::string_view kSpikesHint = "write [probability, extra duration], as in [0.01, 5ms]";
constexpr double kSumTolerance = 1e-3;  // probabilities such as 0.333 are rounded

std::string count_values(const Value& list) {
  return fmt::format("a list of {} value{}", list.items.size(), list.items.size() == 1 ? "" : "s");
}

// Of a node's entry: where it says what its runs wait.
const Value* wait_in(const Value& node) {
  if (node.kind != ValueKind::kMap) return nullptr;
  const auto given =
      std::find_if(node.entries.begin(), node.entries.end(), [](const Entry& entry) { return entry.key == "wait"; });
  return given == node.entries.end() ? nullptr : &given->value;
}

class CostReader {
 public:
  CostReader(const Value& root, const graph::App& app, Problems& problems)
      : root_(root), app_(app), graph_(app.graph), problems_(problems), work_(app.graph) {}

  // `all`: it is to name every node that is scheduled.
  model::Workload read(bool all);
  const std::vector<bool>& given() const { return given_; }

 private:
  struct Mode {
    model::ModeCost cost;
    std::optional<Millis> typical;
  };

  void read_node(const Entry& entry);
  std::optional<model::NodeWork> read_work(const Value& value, const graph::Node& node, const std::string& key);
  std::optional<model::NodeWork> read_law(const Value& value, const MapReader& map, const graph::Node& node,
                                          const std::string& key);
  void read_wait(const Value& node, NodeId id, const std::string& node_key);
  bool read_extras(const MapReader& map, const graph::Node& node, model::NodeWork& work);
  bool read_per_item(const MapReader& map, const graph::Node& node, model::NodeWork& work);
  std::optional<model::NodeWork> read_cost(const MapReader& map);
  std::optional<model::NodeWork> read_threads(const MapReader& map, const graph::Node& node);
  std::optional<model::NodeWork> read_modes(const Value& value, const graph::Node& node, const std::string& key);
  std::optional<Mode> read_mode(const Entry& entry, const graph::Node& node, const std::string& key);
  std::optional<double> read_probability(const Value& value, const std::string& key);
  // Where it is given; a typical cost that does not fit the cost is reported and makes `good` false.
  std::optional<Millis> read_typical(const Value* value, const std::string& key, Millis cost, bool& good);
  const Value* kinds_of(const Value& value) const;
  void read_kinds(const Value& value, NodeId id, const std::string& key);
  void report_missing_nodes();

  const Value& root_;
  const graph::App& app_;
  const graph::Graph& graph_;
  Problems& problems_;
  model::Workload work_;
  std::vector<bool> given_;  // by NodeId
};

model::Workload CostReader::read(bool all) {
  given_.assign(graph_.nodes().size(), false);
  if (!expect(root_, ValueKind::kMap, "", "write one line a node, as in LM: 1.2ms", problems_)) return work_;
  for (const Entry* entry : read_entries(root_, "", problems_)) read_node(*entry);
  if (all) report_missing_nodes();
  return work_;
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
  read_wait(entry.value, *id, key);
  if (const Value* kinds = kinds_of(entry.value)) {
    const MapReader reports_doubled(entry.value, key, kKindsKeys, problems_);
    return read_kinds(*kinds, *id, key);
  }
  if (auto work = read_work(entry.value, node, key)) work_.set(*id, std::move(*work));
}

// The value of `kinds` where it is all that a node's entry holds, but for what its runs wait.
const Value* CostReader::kinds_of(const Value& value) const {
  if (value.kind != ValueKind::kMap) return nullptr;
  const Value* kinds = nullptr;
  for (const Entry& entry : value.entries) {
    if (entry.key == "kinds") kinds = &entry.value;
    if (std::find(kKindsKeys.begin(), kKindsKeys.end(), entry.key) == kKindsKeys.end()) return nullptr;
  }
  return kinds;
}

// Where it is given.
void CostReader::read_wait(const Value& node, NodeId id, const std::string& node_key) {
  const Value* const given = wait_in(node);
  if (given == nullptr) return;
  const std::string key = join_key(node_key, "wait");
  const Value& value = *given;
  const bool has_typical = value.kind == ValueKind::kSequence;
  if (has_typical && value.items.size() != 2) {
    problems_.add(value.place, key, count_values(value), std::string(kWaitHint));
    return;
  }
  if (value.kind == ValueKind::kMap) {
    problems_.add(value.place, key, fmt::format("a duration belongs here, not {}", describe(value)),
                  std::string(kWaitHint));
    return;
  }
  const auto wait =
      has_typical ? read_duration(value.items[0], key + "[0]", problems_) : read_duration(value, key, problems_);
  bool good = wait.has_value();
  const Millis max = wait ? to_millis(wait->value) : Millis::max();
  const auto typical = read_typical(has_typical ? &value.items[1] : nullptr, key + "[1]", max, good);
  if (good) work_.set_wait(id, {max, typical});
}

// The work on each kind of cores. On a core of speed 1 it is what it is on the first kind, times its speed.
void CostReader::read_kinds(const Value& value, NodeId id, const std::string& node_key) {
  const std::string key = join_key(node_key, "kinds");
  if (!expect(value, ValueKind::kMap, key, kKindsHint, problems_)) return;
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
    if (const Value* wait = wait_in(entry->value)) {
      problems_.add(wait->place, join_key(entry_key, "wait"), "a node waits as long on every kind of cores",
                    "put wait beside kinds");
      continue;
    }
    auto work = read_work(entry->value, graph_.node(id), entry_key);
    if (!work) continue;
    const auto kind = static_cast<std::size_t>(found - names.begin());
    if (kind == 0) work_.set(id, work->times(app_.core_kinds.front().speed));
    work_.set_on(id, kind, std::move(*work));
  }
  if (missing.empty()) return;
  problems_.add(value.place, key, fmt::format("no cost for {}", quote_list(missing)), "give every kind of cores one");
}

std::optional<model::NodeWork> CostReader::read_work(const Value& value, const graph::Node& node,
                                                     const std::string& key) {
  if (value.kind == ValueKind::kScalar) {
    const auto cost = read_duration(value, key, problems_);
    if (!cost) return std::nullopt;
    return model::NodeWork::constant(to_millis(cost->value));
  }
  if (value.kind != ValueKind::kMap) {
    problems_.add(value.place, key, fmt::format("a duration belongs here, not {}", describe(value)),
                  std::string(kCostHint));
    return std::nullopt;
  }
  const MapReader map(value, key, kCostKeys, problems_);
  if (map.find("kinds") != nullptr) {
    problems_.add(value.place, key, "costs by kind of cores stand alone",
                  "put the other keys, but for wait, under each kind");
    return std::nullopt;
  }
  auto work = read_law(value, map, node, key);
  model::NodeWork unread;
  const bool extras = read_extras(map, node, work ? *work : unread);
  return extras ? work : std::nullopt;
}

// Without growth, spikes and what items of batches add.
std::optional<model::NodeWork> CostReader::read_law(const Value& value, const MapReader& map, const graph::Node& node,
                                                    const std::string& key) {
  const Value* const threads = map.find("threads");
  const Value* const modes = map.find("modes");
  const Value* const cost = map.find("cost");
  const int given = (cost != nullptr ? 1 : 0) + (threads != nullptr ? 1 : 0) + (modes != nullptr ? 1 : 0);
  if (given > 1) {
    problems_.add(value.place, key, "a cost is given by one of cost, threads and modes", "keep one of them");
    return std::nullopt;
  }
  if (given == 0) {
    const bool misspelt = std::any_of(value.entries.begin(), value.entries.end(), [](const Entry& entry) {
      return std::find(kCostKeys.begin(), kCostKeys.end(), entry.key) == kCostKeys.end();
    });
    if (!misspelt) problems_.add(value.place, key, "the cost is missing", std::string(kCostHint));
    return std::nullopt;
  }
  if (cost != nullptr) return read_cost(map);
  if (threads != nullptr) return read_threads(map, node);
  const Value* const typical = map.find("typical");
  if (typical != nullptr) {
    problems_.add(typical->place, map.key_of("typical"), "each mode has its own",
                  "write it behind the mode's cost, as in skip: [0.8, 1.1ms, 0.9ms]");
  }
  auto work = read_modes(*modes, node, map.key_of("modes"));
  return typical == nullptr ? work : std::nullopt;
}

// Where it is given.
bool CostReader::read_per_item(const MapReader& map, const graph::Node& node, model::NodeWork& work) {
  const Value* const value = map.find("per_item");
  if (value == nullptr) return true;
  const auto per_item = read_duration(*value, map.key_of("per_item"), problems_);
  if (node.input != graph::InputKind::kQueue) {
    problems_.add(value->place, map.key_of("per_item"), "the node takes no batches: it has no input: queue",
                  "remove it, or add input: queue to the node in the app file");
    return false;
  }
  if (per_item) work.cost = work.cost.with_per_item(to_millis(per_item->value));
  return per_item.has_value();
}

bool CostReader::read_extras(const MapReader& map, const graph::Node& node, model::NodeWork& work) {
  bool good = read_per_item(map, node, work);
  if (const Value* const grow = map.find("grow")) {
    const auto growth = read_growth(*grow, map.key_of("grow"), problems_);
    good = good && growth.has_value();
    work.growth = growth.value_or(0.0);
  }
  const Value* const spikes = map.find("spikes");
  if (spikes == nullptr) return good;
  const std::string key = map.key_of("spikes");
  if (!expect(*spikes, ValueKind::kSequence, key, kSpikesHint, problems_)) return false;
  if (spikes->items.size() != 2) {
    problems_.add(spikes->place, key, count_values(*spikes), std::string(kSpikesHint));
    return false;
  }
  const auto probability = read_probability(spikes->items[0], key + "[0]");
  const auto extra = read_duration(spikes->items[1], key + "[1]", problems_);
  if (!probability || !extra) return false;
  work.spikes = {*probability, to_millis(extra->value)};
  return good;
}

std::optional<Millis> CostReader::read_typical(const Value* value, const std::string& key, Millis cost, bool& good) {
  if (value == nullptr) return std::nullopt;
  const auto typical = read_positive_duration(*value, key, problems_);
  if (!typical) {
    good = false;
    return std::nullopt;
  }
  if (to_millis(typical->value) > cost) {
    problems_.add(value->place, key, "a typical run costs no more than the 95th percentile of all",
                  cost > Millis{0} ? fmt::format("write at most {}", format_duration(to_nanos(cost))) : "remove it");
    good = false;
  }
  return to_millis(typical->value);
}

std::optional<model::NodeWork> CostReader::read_cost(const MapReader& map) {
  const auto cost = read_duration(*map.find("cost"), map.key_of("cost"), problems_);
  bool good = cost.has_value();
  // Where the cost is wrong, a typical cost is checked by itself, not against the cost.
  const Millis max = cost ? to_millis(cost->value) : Millis::max();
  const auto typical = read_typical(map.find("typical"), map.key_of("typical"), max, good);
  if (!good) return std::nullopt;
  model::NodeWork work = model::NodeWork::constant(max);
  if (typical) work.typical = {typical};
  return work;
}

std::optional<model::NodeWork> CostReader::read_threads(const MapReader& map, const graph::Node& node) {
  const Value& value = *map.find("threads");
  const std::string key = map.key_of("threads");
  if (!expect(value, ValueKind::kMap, key, kThreadsHint, problems_)) return std::nullopt;
  std::map<int, Millis> elapsed;
  bool good = true;
  for (const Entry* entry : read_entries(value, key, problems_)) {
    const std::string entry_key = join_key(key, entry->key);
    const Value number{ValueKind::kScalar, entry->key, false, false, entry->place, {}, {}};
    const auto threads = read_int(number, entry_key, 1, node.max_threads, problems_);
    const auto cost = read_duration(entry->value, entry_key, problems_);
    good = good && threads && cost;
    if (!threads || !cost) continue;
    if (!elapsed.try_emplace(threads->value, to_millis(cost->value)).second) {
      problems_.add(entry->place, entry_key, fmt::format("the time with {} threads was given before", threads->value),
                    "keep one of them");
    }
  }
  const bool alone_given = elapsed.contains(1);
  const Millis alone = alone_given ? elapsed.at(1) : Millis::max();
  if (good && !alone_given) {
    problems_.add(value.place, key, "the time with 1 thread is missing", "add 1: with the time that one thread takes");
  }
  good = good && alone_given;
  const auto typical = read_typical(map.find("typical"), map.key_of("typical"), alone, good);
  if (!good) return std::nullopt;
  model::NodeWork work;
  work.cost = model::CostProfile::of_threads(std::move(elapsed));
  if (typical) work.typical = {typical};
  return work;
}

std::optional<model::NodeWork> CostReader::read_modes(const Value& value, const graph::Node& node,
                                                      const std::string& key) {
  if (!expect(value, ValueKind::kMap, key, kModesHint, problems_)) return std::nullopt;
  if (node.modes.empty()) {
    problems_.add(value.place, key, "the app declares no modes for this node",
                  fmt::format("write {}: with one duration, or add modes to the node in the app file", node.name));
    return std::nullopt;
  }
  std::vector<std::optional<Mode>> modes(node.modes.size());  // as the app declares them
  std::vector<std::string> missing = node.modes;
  bool whole = true;
  double sum = 0.0;
  std::size_t read = 0;
  for (const Entry* entry : read_entries(value, key, problems_)) {
    std::erase(missing, entry->key);
    auto mode = read_mode(*entry, node, join_key(key, entry->key));
    whole = whole && mode;
    if (!mode) continue;
    sum += mode->cost.probability;
    ++read;
    const auto declared = std::find(node.modes.begin(), node.modes.end(), entry->key) - node.modes.begin();
    modes[static_cast<std::size_t>(declared)] = std::move(*mode);
  }
  if (!missing.empty()) {
    problems_.add(value.place, key, fmt::format("no cost for mode {}", quote_list(missing)),
                  "give every mode that the app declares, with probability 0 if it never happens");
    return std::nullopt;
  }
  if (!whole || read < value.entries.size()) return std::nullopt;  // a doubled mode was reported
  if (std::abs(sum - 1.0) > kSumTolerance) {
    problems_.add(value.place, key, fmt::format("the probabilities add up to {:.4g}", sum), "make them add up to 1");
    return std::nullopt;
  }
  model::NodeWork work;
  std::vector<model::ModeCost> costs;
  for (std::optional<Mode>& mode : modes) {
    mode->cost.probability /= sum;
    costs.push_back(std::move(mode->cost));
    work.typical.push_back(mode->typical);
  }
  work.cost = model::CostProfile::of_modes(std::move(costs));
  return work;
}

std::optional<CostReader::Mode> CostReader::read_mode(const Entry& entry, const graph::Node& node,
                                                      const std::string& key) {
  bool good = true;
  if (std::find(node.modes.begin(), node.modes.end(), entry.key) == node.modes.end()) {
    const auto meant = nearest(entry.key, node.modes);
    problems_.add(entry.place, key, "the app declares no such mode",
                  meant ? fmt::format("did you mean {}?", quote(*meant))
                        : fmt::format("the modes are {}", quote_list(node.modes)));
    good = false;
  }
  constexpr std::string_view kHint = "write [probability, duration], as in [0.8, 1.1ms]";
  if (!expect(entry.value, ValueKind::kSequence, key, kHint, problems_)) return std::nullopt;
  const std::vector<Value>& items = entry.value.items;
  if (items.size() != 2 && items.size() != 3) {
    problems_.add(entry.value.place, key, count_values(entry.value), std::string(kHint));
    return std::nullopt;
  }
  const auto probability = read_probability(items[0], key + "[0]");
  const auto cost = read_duration(items[1], key + "[1]", problems_);
  const Millis max = cost ? to_millis(cost->value) : Millis::max();
  const auto typical = read_typical(items.size() == 3 ? &items[2] : nullptr, key + "[2]", max, good);
  if (!good || !probability || !cost) return std::nullopt;
  return Mode{{entry.key, *probability, max}, typical};
}

std::optional<double> CostReader::read_probability(const Value& value, const std::string& key) {
  const auto probability = read_number(value, key, problems_);
  if (!probability) return std::nullopt;
  if (probability->value >= 0.0 && probability->value <= 1.0) return probability->value;
  problems_.add(value.place, key, fmt::format("{} is no probability", describe(value)), "write a number from 0 to 1");
  return std::nullopt;
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

Result<model::Workload> parse_workload(std::string_view text, std::string_view file, const graph::App& app) {
  const auto root = parse_yaml(text, file, "docs/cost-file.md");
  if (!root) return root.error();
  Problems problems;
  model::Workload work = CostReader(*root, app, problems).read(true);
  if (!problems.empty()) return std::move(problems).to_error();
  return work;
}

Result<model::Workload> load_workload(const std::string& path, const graph::App& app) {
  const auto text = read_text(path);
  if (!text) return text.error();
  return parse_workload(*text, path, app);
}

Result<PartialWorkload> load_partial_workload(const std::string& path, const graph::App& app) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const auto root = parse_yaml(*text, path, "docs/cost-file.md");
  if (!root) return root.error();
  Problems problems;
  CostReader reader(*root, app, problems);
  PartialWorkload read{reader.read(false), reader.given()};
  if (!problems.empty()) return std::move(problems).to_error();
  return read;
}

Result<model::CostTable> parse_costs(std::string_view text, std::string_view file, const graph::App& app) {
  const auto work = parse_workload(text, file, app);
  if (!work) return work.error();
  return work->costs(app.graph);
}

Result<model::CostTable> load_costs(const std::string& path, const graph::App& app) {
  const auto work = load_workload(path, app);
  if (!work) return work.error();
  return work->costs(app.graph);
}

}  // namespace ctn::config
