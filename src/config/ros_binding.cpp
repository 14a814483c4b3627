#include "config/ros_binding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/text.h"
#include "config/collected_callbacks.h"
#include "config/read.h"

namespace ctn::config {
namespace {

constexpr std::array<std::string_view, 5> kRosKeys{"node", "nodelet", "topic", "timer", "service"};
constexpr std::array<std::string_view, 2> kBindFileKeys{"catan", "ros"};
constexpr std::string_view kHertz = "Hz";
constexpr std::string_view kRosHint =
    "write it as in {node: /mapper, topic: /scan}, {node: /mapper, timer: 100ms} or {node: /mapper, service: /save}";

std::optional<std::string> read_ros_name(const Value& value, const std::string& key, Problems& problems) {
  const std::optional<graph::Name> name = read_name(value, key, problems);
  if (!name) return std::nullopt;
  const std::string& text = name->value;
  const bool has_blanks =
      std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) <= ' '; });
  if (text.size() > 1 && text.front() == '/' && !has_blanks) return text;
  problems.add(value.place, key, fmt::format("{} is not the full name of anything in ROS", quote(text)),
               "begin it with a slash, as rosnode list and rostopic list print it: /mapper, /robot/scan");
  return std::nullopt;
}

// A period, or the rate that the program has asked for.
std::optional<Nanos> read_timer(const Value& value, const std::string& key, Problems& problems) {
  const bool is_rate = value.kind == ValueKind::kScalar && value.text.size() > kHertz.size() &&
                       std::string_view(value.text).substr(value.text.size() - kHertz.size()) == kHertz;
  if (is_rate) {
    const auto rate = read_rate(value, key, problems);
    return rate ? std::optional(std::chrono::round<Nanos>(rate->value.period())) : std::nullopt;
  }
  const auto period = read_positive_duration(value, key, problems);
  return period ? std::optional(period->value) : std::nullopt;
}

void collect_bind_file(const Value& root, CollectedCallbacks<RosCallback>& collected, Problems& problems) {
  constexpr std::string_view kHint = "begin the file with catan: 1, and go on with ros:";
  if (!expect(root, ValueKind::kMap, "", kHint, problems)) return;
  const MapReader map(root, "", kBindFileKeys, problems);
  const Value* const version = map.find("catan");
  if (version == nullptr) {
    problems.add(root.place, "catan", "the version of the format is missing", "begin the file with catan: 1");
  } else if (expect(*version, ValueKind::kScalar, "catan", "write catan: 1", problems) && version->text != "1") {
    problems.add(version->place, "catan", fmt::format("version {} of the format is not known", quote(version->text)),
                 "write catan: 1");
  }
  const Value* const ros = map.find("ros");
  if (ros == nullptr) {
    problems.add(root.place, "ros", "the callbacks are missing", "add ros: with one entry a node");
  } else if (expect(*ros, ValueKind::kMap, "ros", "write one entry a node, as in GL: {node: /gl, topic: /scan}",
                    problems)) {
    for (const Entry* entry : read_entries(*ros, "ros", problems)) {
      collected.add(*entry, entry->value, join_key("ros", entry->key));
    }
  }
}

}  // namespace

std::optional<RosCallback> read_ros_callback(const Value& value, const std::string& key, Problems& problems) {
  if (!expect(value, ValueKind::kMap, key, kRosHint, problems)) return std::nullopt;
  const MapReader map(value, key, kRosKeys, problems);
  const Value* const node = map.find("node");
  const Value* const nodelet = map.find("nodelet");
  const Value* const topic = map.find("topic");
  const Value* const timer = map.find("timer");
  const Value* const service = map.find("service");
  if (node == nullptr) {
    problems.add(value.place, key, "the ROS node is missing", std::string(kRosHint));
    return std::nullopt;
  }
  if ((topic != nullptr ? 1 : 0) + (timer != nullptr ? 1 : 0) + (service != nullptr ? 1 : 0) != 1) {
    problems.add(value.place, key, "a callback has one of topic, timer and service", std::string(kRosHint));
    return std::nullopt;
  }
  RosCallback callback;
  callback.place = value.place;
  std::optional<std::string> name = read_ros_name(*node, map.key_of("node"), problems);
  if (!name) return std::nullopt;
  callback.node = std::move(*name);
  if (nodelet != nullptr) {
    name = read_ros_name(*nodelet, map.key_of("nodelet"), problems);
    if (!name) return std::nullopt;
    callback.nodelet = std::move(*name);
  }
  if (timer != nullptr) {
    callback.kind = RosCallback::Kind::kTimer;
    const std::optional<Nanos> period = read_timer(*timer, map.key_of("timer"), problems);
    if (!period) return std::nullopt;
    callback.period = *period;
    return callback;
  }
  callback.kind = topic != nullptr ? RosCallback::Kind::kTopic : RosCallback::Kind::kService;
  name = topic != nullptr ? read_ros_name(*topic, map.key_of("topic"), problems)
                          : read_ros_name(*service, map.key_of("service"), problems);
  if (!name) return std::nullopt;
  callback.name = std::move(*name);
  return callback;
}

std::vector<RosBinding> read_ros_bindings(const Value& root, const graph::App& app, Problems& problems) {
  CollectedCallbacks<RosCallback> collected("ros", read_ros_callback, app, problems);
  collected.add_app_file(root);
  return collected.take();
}

std::vector<NodeId> nodes_needing_input(const std::vector<RosBinding>& bindings) {
  std::vector<NodeId> nodes;
  for (const auto& [node, callback] : bindings) {
    if (callback.kind == RosCallback::Kind::kTopic) nodes.push_back(node);
  }
  return nodes;
}

Status check_without_nodelets(const std::vector<RosBinding>& bindings, const graph::App& app) {
  Problems problems;
  for (const auto& [node, callback] : bindings) {
    if (callback.nodelet.empty()) continue;
    problems.add(callback.place, fmt::format("{}: ros.nodelet", app.graph.node(node).name), "ROS 2 has no nodelets",
                 "name the component by node:, and leave nodelet: out");
  }
  if (!problems.empty()) return std::move(problems).to_error();
  return Done{};
}

namespace {

// What a service may wait for, and the node whose run then waits for its answer.
struct WaitForEachOther {
  NodeId caller;
  bool in_its_subchain;  // else a trigger by outputs
};

const RosCallback* find_callback(const std::vector<RosBinding>& bindings, NodeId node) {
  const auto found = std::find_if(bindings.begin(), bindings.end(),
                                  [node](const RosBinding& binding) { return binding.node == node; });
  return found == bindings.end() ? nullptr : &found->callback;
}

// Of its own program a callback cannot call a service: the spinner is in the callback. There it gives data by memory.
bool may_call(const RosCallback* caller, const RosCallback& service) {
  return caller != nullptr && (caller->node != service.node || caller->nodelet != service.nodelet);
}

// A subchain with trigger: any may follow any other; what is unscheduled triggers those that it feeds.
bool may_trigger(const graph::App& app, NodeId node, NodeId head) {
  const graph::Node& from = app.graph.node(node);
  const graph::TriggerBy by = app.graph.node(head).trigger;
  if (by == graph::TriggerBy::kTime) return false;
  if (from.subchain) return by == graph::TriggerBy::kAny && from.subchain != app.graph.node(head).subchain;
  return std::find(from.successors.begin(), from.successors.end(), head) != from.successors.end();
}

std::optional<WaitForEachOther> find_caller(const std::vector<RosBinding>& bindings, const graph::App& app,
                                            const RosBinding& service) {
  const graph::Subchain& subchain = app.graph.subchain(*app.graph.node(service.node).subchain);
  for (const NodeId before : subchain.nodes) {
    if (before == service.node) break;
    if (may_call(find_callback(bindings, before), service.callback)) return WaitForEachOther{before, true};
  }
  for (const RosBinding& other : bindings) {
    if (!may_trigger(app, other.node, subchain.head())) continue;
    if (may_call(&other.callback, service.callback)) return WaitForEachOther{other.node, false};
  }
  return std::nullopt;
}

}  // namespace

Status check_services(const std::vector<RosBinding>& bindings, const graph::App& app) {
  Problems problems;
  for (const RosBinding& service : bindings) {
    const std::optional<SubchainId> subchain = app.graph.node(service.node).subchain;
    if (service.callback.kind != RosCallback::Kind::kService || !subchain) continue;
    const std::optional<WaitForEachOther> wait = find_caller(bindings, app, service);
    if (!wait) continue;
    const std::string& name = app.graph.node(service.node).name;
    const std::string& caller = app.graph.node(wait->caller).name;
    const std::string& head = app.graph.node(app.graph.subchain(*subchain).head()).name;
    const std::string if_called =
        fmt::format("if {} calls {}, both wait for each other for ever", caller, service.callback.name);
    const std::string key = fmt::format("{}: ros.service", name);
    if (wait->in_its_subchain) {
      problems.add(service.callback.place, key,
                   fmt::format("in subchain {} it is triggered behind {}: {}",
                               quote(app.graph.subchain(*subchain).name), quote(caller), if_called),
                   fmt::format("leave {} out of the subchain, with trigger: time; if it works with what {} publishes, "
                               "bind the callback that gets that, by topic:",
                               quote(name), quote(caller)));
    } else {
      problems.add(service.callback.place, key,
                   fmt::format("outputs of {} may trigger it: {}", quote(caller), if_called),
                   fmt::format("write trigger: time in nodes.{}", head));
    }
  }
  if (!problems.empty()) return std::move(problems).to_error();
  return Done{};
}

Result<std::vector<RosBinding>> ros_bindings(std::string_view app_text, std::string_view file, const graph::App& app) {
  return callbacks_of_app_file<RosCallback>(app_text, file, app, "ros", read_ros_callback);
}

Result<std::vector<RosBinding>> ros_bindings(std::string_view app_text, std::string_view file, const graph::App& app,
                                             std::string_view bind_text, std::string_view bind_file) {
  const auto root = parse_yaml(app_text, file, "docs/app-file.md");
  if (!root) return root.error();
  const auto bind_root = parse_yaml(bind_text, bind_file, "docs/ros1.md");
  if (!bind_root) return bind_root.error();
  Problems problems;
  CollectedCallbacks<RosCallback> collected("ros", read_ros_callback, app, problems);
  collect_bind_file(*bind_root, collected, problems);
  collected.add_app_file(*root);
  if (!problems.empty()) return std::move(problems).to_error();
  return collected.take();
}

}  // namespace ctn::config
