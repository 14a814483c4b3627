#include "config/app_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "config/illixr_binding.h"
#include "config/ros_binding.h"

namespace ctn::config {
namespace {

using graph::At;
using Keys = std::string_view;
constexpr std::array<Keys, 11> kTopKeys{"catan",     "app",   "nodes", "edges",     "subchains", "exclusive",
                                        "objective", "order", "steal", "scheduler", "cores"};
constexpr std::array<Keys, 2> kCoreKeys{"count", "speed"};
constexpr std::array<Keys, 13> kNodeKeys{"input",         "modes",    "external", "unscheduled", "period",
                                         "output_period", "min_rate", "max_rate", "max_threads", "fallback_rate",
                                         "trigger",       "ros",      "illixr"};
constexpr std::array<Keys, 3> kEdgeKeys{"path", "max_age", "on_stale"};
constexpr std::array<Keys, 4> kTermKeys{"response_time", "period", "weight", "max"};
constexpr std::array<Keys, 2> kStealKeys{"priority", "off"};
constexpr std::array<Keys, 10> kSchedulerKeys{"slack",     "frames",         "min_slice", "window",  "percentile",
                                              "bootstrap", "bootstrap_cost", "replan",    "planner", "schedule"};
constexpr std::array<Keys, 2> kInputs{"latest", "queue"};
constexpr std::array<Keys, 3> kTriggers{"time", "arrival", "any"};
constexpr std::array<Keys, 2> kFrames{"elastic", "fixed"};
constexpr std::array<Keys, 2> kPlanners{"auto", "paper"};
constexpr std::array<Keys, 3> kSchedules{"auto", "frames", "priorities"};
constexpr std::array<Keys, 2> kOnStale{"run", "skip"};

constexpr std::string_view kListHint = "write it as in [scan, LM, LP]";
constexpr int kMaxCores = 1024;
constexpr int kMaxRuns = 1'000'000;

}  // namespace

graph::AppSpec AppReader::read() {
  if (!expect(root_, ValueKind::kMap, "", "begin the file with catan: 1", problems_)) {
    all_read_ = false;
    return spec_;
  }
  const MapReader map(root_, "", kTopKeys, problems_);
  read_version(map);
  read_app_name(map);
  read_cores(map);
  read_nodes(map);
  read_edges(map);
  read_subchains(map);
  read_exclusive(map);
  read_objective(map);
  read_order(map);
  read_steal(map);
  read_scheduler(map);
  return spec_;
}

void AppReader::read_version(const MapReader& map) {
  const Value* version = map.find("catan");
  if (version == nullptr) {
    problems_.add(root_.place, "catan", "the version of the format is missing", "begin the file with catan: 1");
  } else if (expect(*version, ValueKind::kScalar, "catan", "write catan: 1", problems_) && version->text != "1") {
    problems_.add(version->place, "catan", fmt::format("version {} of the format is not known", quote(version->text)),
                  "write catan: 1");
  }
}

void AppReader::read_app_name(const MapReader& map) {
  spec_.name.place = root_.place;
  const Value* name = map.find("app");
  if (name == nullptr) {
    problems_.add(root_.place, "app", "the app's name is missing", "add app: NAME");
  } else if (auto read = read_name(*name, "app", problems_)) {
    spec_.name = std::move(*read);
    if (spec_.name.value.empty()) problems_.add(name->place, "app", "the app's name is empty", "write app: NAME");
  }
}

void AppReader::read_cores(const MapReader& map) {
  const Value* cores = map.find("cores");
  if (cores == nullptr) return;
  constexpr std::string_view kHint = "write one entry a kind, as in big: { count: 2, speed: 1.0 }";
  if (!expect(*cores, ValueKind::kMap, "cores", kHint, problems_)) return;
  if (cores->entries.empty()) problems_.add(cores->place, "cores", "no kind of cores is named", std::string(kHint));
  for (const Entry* entry : read_entries(*cores, "cores", problems_)) {
    const std::string key = join_key("cores", entry->key);
    if (!expect(entry->value, ValueKind::kMap, key, kHint, problems_)) continue;
    const MapReader keys(entry->value, key, kCoreKeys, problems_);
    graph::CoreKindSpec kind;
    kind.name = {entry->key, entry->place};
    if (const Value* count = keys.find("count")) {
      if (auto number = read_int(*count, keys.key_of("count"), 1, kMaxCores, problems_)) kind.count = *number;
    }
    if (const Value* speed = keys.find("speed")) {
      if (auto number = read_number(*speed, keys.key_of("speed"), problems_)) kind.speed = *number;
    }
    spec_.core_kinds.push_back(std::move(kind));
  }
}

void AppReader::read_nodes(const MapReader& map) {
  const Value* nodes = map.find("nodes");
  if (nodes == nullptr) {
    problems_.add(root_.place, "nodes", "the nodes are missing", "add nodes: with one entry a node, as in scan: {}");
    all_read_ = false;
    return;
  }
  if (!expect(*nodes, ValueKind::kMap, "nodes", "write one entry a node, as in scan: {}", problems_)) {
    all_read_ = false;
    return;
  }
  for (const Entry* entry : read_entries(*nodes, "nodes", problems_)) {
    spec_.nodes.push_back(read_node(*entry, join_key("nodes", entry->key)));
  }
}

graph::NodeSpec AppReader::read_node(const Entry& entry, const std::string& key) {
  graph::NodeSpec node;
  node.name = {entry.key, entry.place};
  const std::string hint = fmt::format("write {}: {{}} where all is default", join_key("", entry.key));
  if (!expect(entry.value, ValueKind::kMap, key, hint, problems_)) return node;
  const MapReader map(entry.value, key, kNodeKeys, problems_);
  const auto optional = [&](std::string_view name, auto function, auto& field) {
    const Value* value = map.find(name);
    if (value == nullptr) return;
    if (auto result = function(*value, map.key_of(name), problems_)) field = std::move(*result);
  };
  if (const Value* input = map.find("input")) {
    const auto word = read_word(*input, map.key_of("input"), kInputs, problems_);
    if (word == 1) node.input = graph::InputKind::kQueue;
  }
  if (const Value* modes = map.find("modes")) {
    if (auto names = read_names(*modes, map.key_of("modes"), "write it as in [skip, match]", problems_)) {
      node.modes = std::move(*names);
    }
  }
  optional("external", read_bool, node.external);
  optional("unscheduled", read_bool, node.unscheduled);
  optional("period", read_positive_duration, node.period);
  optional("output_period", read_positive_duration, node.output_period);
  optional("min_rate", read_rate, node.min_rate);
  optional("max_rate", read_rate, node.max_rate);
  optional("fallback_rate", read_rate, node.fallback_rate);
  if (const Value* threads = map.find("max_threads")) {
    node.max_threads = read_int(*threads, map.key_of("max_threads"), 1, graph::kMaxThreads, problems_);
  }
  if (const Value* trigger = map.find("trigger")) {
    constexpr std::array kBy{graph::TriggerBy::kTime, graph::TriggerBy::kArrival, graph::TriggerBy::kAny};
    const auto word = read_word(*trigger, map.key_of("trigger"), kTriggers, problems_);
    if (word) node.trigger = At<graph::TriggerBy>{kBy[*word], trigger->place};
  }
  if (const Value* ros = map.find("ros")) static_cast<void>(read_ros_callback(*ros, map.key_of("ros"), problems_));
  if (const Value* illixr = map.find("illixr")) {
    static_cast<void>(read_illixr_callback(*illixr, map.key_of("illixr"), problems_));
  }
  return node;
}

void AppReader::read_edges(const MapReader& map) {
  const Value* edges = map.find("edges");
  if (edges == nullptr) return;  // an app of one node has none
  if (!expect(*edges, ValueKind::kSequence, "edges", "write a list of paths, as in - scan -> LM", problems_)) {
    all_read_ = false;
    return;
  }
  for (std::size_t i = 0; i < edges->items.size(); ++i) {
    if (auto path = read_edge(edges->items[i], fmt::format("edges[{}]", i))) {
      spec_.edges.push_back(std::move(*path));
    } else {
      all_read_ = false;
    }
  }
}

// A path, or a map of a path and what it says of the age of data.
std::optional<graph::PathSpec> AppReader::read_edge(const Value& value, const std::string& key) {
  if (value.kind != ValueKind::kMap) return read_path(value, key);
  const MapReader map(value, key, kEdgeKeys, problems_);
  std::optional<At<Nanos>> max_age;
  std::optional<At<graph::OnStale>> on_stale;
  if (const Value* age = map.find("max_age")) {
    max_age = read_positive_duration(*age, map.key_of("max_age"), problems_);
    // So that what rests on it is not reported, too.
    if (!max_age) max_age = At<Nanos>{Nanos{1}, age->place};
  }
  if (const Value* stale = map.find("on_stale")) {
    const auto word = read_word(*stale, map.key_of("on_stale"), kOnStale, problems_);
    on_stale = At<graph::OnStale>{word == 1 ? graph::OnStale::kSkip : graph::OnStale::kRun, stale->place};
  }
  const Value* written = map.find("path");
  if (written == nullptr) {
    problems_.add(value.place, map.key_of("path"), "the path is missing", "add path: scan -> LM, say");
    return std::nullopt;
  }
  std::optional<graph::PathSpec> path = read_path(*written, map.key_of("path"));
  if (!path) return std::nullopt;
  path->max_age = max_age;
  path->on_stale = on_stale;
  return path;
}

// "scan -> LM -> LP", each name with its own place where the text stands on one line as it is.
std::optional<graph::PathSpec> AppReader::read_path(const Value& value, const std::string& key) {
  if (!expect(value, ValueKind::kScalar, key, "write a path, as in scan -> LM", problems_)) return std::nullopt;
  graph::PathSpec path{{}, value.place};
  const std::string_view text = value.text;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t arrow = std::min(text.find("->", begin), text.size());
    const std::string_view name = trimmed(text.substr(begin, arrow - begin));
    graph::Name node{std::string(name), value.place};
    if (value.verbatim && !name.empty()) node.place.column += static_cast<int>(name.data() - text.data());
    if (name.empty()) {
      problems_.add(value.place, key, fmt::format("a node is missing in {}", quote(text)),
                    "write nodes with -> between them, as in scan -> LM");
      return std::nullopt;
    }
    path.nodes.push_back(std::move(node));
    begin = arrow + 2;
  }
  return path;
}

void AppReader::read_subchains(const MapReader& map) {
  const Value* subchains = map.find("subchains");
  if (subchains == nullptr) return;
  if (!expect(*subchains, ValueKind::kMap, "subchains", "write entries such as local: [scan, LM, LP]", problems_)) {
    all_read_ = false;
    return;
  }
  for (const Entry* entry : read_entries(*subchains, "subchains", problems_)) {
    graph::SubchainSpec spec{{entry->key, entry->place}, {}};
    if (auto names = read_names(entry->value, join_key("subchains", entry->key), kListHint, problems_)) {
      spec.nodes = std::move(*names);
      spec_.subchains.push_back(std::move(spec));
    } else {
      all_read_ = false;
    }
  }
}

void AppReader::read_exclusive(const MapReader& map) {
  const Value* groups = map.find("exclusive");
  if (groups == nullptr) return;
  constexpr std::string_view kHint = "write entries such as slam: [scan, timer]";
  if (!expect(*groups, ValueKind::kMap, "exclusive", kHint, problems_)) return;
  for (const Entry* entry : read_entries(*groups, "exclusive", problems_)) {
    auto names = read_names(entry->value, join_key("exclusive", entry->key), kListHint, problems_);
    if (names) spec_.exclusive.push_back({{entry->key, entry->place}, std::move(*names)});
  }
}

void AppReader::read_objective(const MapReader& map) {
  const Value* objective = map.find("objective");
  if (objective == nullptr) return;  // build_app says what is missing
  constexpr std::string_view kHint = "write a list of terms, as in - { period: GL, weight: 0.5 }";
  if (!expect(*objective, ValueKind::kSequence, "objective", kHint, problems_)) return;
  if (objective->items.empty()) {
    problems_.add(objective->place, "objective", "the objective is empty, so that no plan is better than another",
                  "add a response_time or a period with its weight");
  }
  for (std::size_t i = 0; i < objective->items.size(); ++i) {
    const std::string key = fmt::format("objective[{}]", i);
    if (auto term = read_term(objective->items[i], key)) {
      spec_.objective.push_back(std::move(*term));
    } else {
      all_read_ = false;
    }
  }
}

std::optional<graph::TermSpec> AppReader::read_term(const Value& value, const std::string& key) {
  if (!expect(value, ValueKind::kMap, key, "write it as in { period: GL, weight: 0.5 }", problems_))
    return std::nullopt;
  const MapReader map(value, key, kTermKeys, problems_);
  graph::TermSpec term;
  term.place = value.place;
  term.weight.place = value.place;
  const Value* weight = map.find("weight");
  if (weight == nullptr) {
    problems_.add(value.place, map.key_of("weight"), "the weight is missing", "add weight: 1.0, say");
  } else if (auto number = read_number(*weight, map.key_of("weight"), problems_)) {
    term.weight = *number;
  }
  if (const Value* max = map.find("max")) term.max = read_duration(*max, map.key_of("max"), problems_);
  const Value* response_time = map.find("response_time");
  const Value* period = map.find("period");
  if ((response_time == nullptr) == (period == nullptr)) {
    problems_.add(value.place, key,
                  period == nullptr ? "the term names neither a response_time nor a period"
                                    : "the term names both a response_time and a period",
                  "write one of them, and two terms for both");
    return std::nullopt;
  }
  if (period != nullptr) {
    term.metric = graph::Metric::kPeriod;
    auto name = read_name(*period, map.key_of("period"), problems_);
    if (!name) return std::nullopt;
    term.path.push_back(std::move(*name));
    return term;
  }
  auto names = read_names(*response_time, map.key_of("response_time"), kListHint, problems_);
  if (!names) return std::nullopt;
  term.path = std::move(*names);
  return term;
}

void AppReader::read_order(const MapReader& map) {
  if (const Value* order = map.find("order")) spec_.order = read_names(*order, "order", kListHint, problems_);
}

void AppReader::read_steal(const MapReader& map) {
  const Value* steal = map.find("steal");
  if (steal == nullptr) return;
  constexpr std::string_view kHint = "write it as in { priority: [local, GL], off: [] }";
  if (!expect(*steal, ValueKind::kMap, "steal", kHint, problems_)) return;
  const MapReader keys(*steal, "steal", kStealKeys, problems_);
  if (const Value* priority = keys.find("priority")) {
    spec_.steal_priority = read_names(*priority, "steal.priority", kListHint, problems_);
  }
  if (const Value* off = keys.find("off")) {
    if (auto names = read_names(*off, "steal.off", kListHint, problems_)) spec_.steal_off = std::move(*names);
  }
}

void AppReader::read_scheduler(const MapReader& map) {
  const Value* scheduler = map.find("scheduler");
  if (scheduler == nullptr) return;
  if (!expect(*scheduler, ValueKind::kMap, "scheduler", "write it as in { slack: auto }", problems_)) return;
  const MapReader keys(*scheduler, "scheduler", kSchedulerKeys, problems_);
  graph::SchedulerOptions& options = spec_.scheduler;
  const auto duration = [&](std::string_view name, auto function, Nanos& field) {
    const Value* value = keys.find(name);
    if (value == nullptr) return;
    if (const auto result = function(*value, keys.key_of(name), problems_)) field = result->value;
  };
  if (const Value* slack = keys.find("slack"); slack != nullptr && slack->text != "auto") {
    options.slack = read_percentage(*slack, "scheduler.slack", problems_);
  }
  if (const Value* frames = keys.find("frames")) {
    if (read_word(*frames, "scheduler.frames", kFrames, problems_) == 1) options.frames = graph::FrameMode::kFixed;
  }
  if (const Value* planner = keys.find("planner")) {
    const auto word = read_word(*planner, "scheduler.planner", kPlanners, problems_);
    if (word == 1) options.planner = graph::PlannerKind::kPaper;
  }
  if (const Value* schedule = keys.find("schedule")) {
    const auto word = read_word(*schedule, "scheduler.schedule", kSchedules, problems_);
    if (word == 1) options.schedule = graph::ScheduleKind::kFrames;
    if (word == 2) options.schedule = graph::ScheduleKind::kPriorities;
    if (word == 2 && options.planner == graph::PlannerKind::kPaper) {
      problems_.add(schedule->place, "scheduler.schedule", "the paper's planner knows frames alone",
                    "leave out schedule, or planner: paper");
    }
  }
  duration("min_slice", read_positive_duration, options.min_slice);
  duration("bootstrap", read_duration, options.bootstrap);
  duration("bootstrap_cost", read_positive_duration, options.bootstrap_cost);
  duration("replan", read_positive_duration, options.replan);
  if (const Value* window = keys.find("window")) {
    if (auto runs = read_int(*window, "scheduler.window", 1, kMaxRuns, problems_)) options.window = runs->value;
  }
  if (const Value* percentile = keys.find("percentile")) {
    const auto number = read_number(*percentile, "scheduler.percentile", problems_);
    if (number && (number->value <= 0.0 || number->value > 100.0)) {
      problems_.add(number->place, "scheduler.percentile", fmt::format("{} is out of range", quote(percentile->text)),
                    "write a number above 0, at most 100");
    } else if (number) {
      options.percentile = number->value;
    }
  }
}

}  // namespace ctn::config
