// Collects which node of an app is which callback of a framework, from where its user has written it: each node once,
// what comes first counts.
//
// Thread safety: one thread.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/text.h"
#include "config/callback_binding.h"
#include "config/problems.h"
#include "config/read.h"
#include "config/yaml.h"
#include "graph/app.h"

namespace ctn::config {

template <class Callback>
class CollectedCallbacks {
 public:
  using Read = std::optional<Callback> (*)(const Value& value, const std::string& key, Problems& problems);

  // `key` is the framework's at a node of the app file. `app` and `problems` outlive it.
  CollectedCallbacks(std::string key, Read read, const graph::App& app, Problems& problems)
      : key_(std::move(key)), read_(read), app_(app), problems_(problems) {}

  // Of the node that `entry` names; `value` is what stands at `key`.
  void add(const Entry& entry, const Value& value, const std::string& key) {
    std::optional<Callback> callback = read_(value, key, problems_);
    if (!callback) return;
    const std::optional<NodeId> node = app_.graph.find_node(entry.key);
    if (!node) {
      problems_.add(entry.place, key, fmt::format("app {} has no node {}", app_.name, quote(entry.key)),
                    "write a name from its nodes section");
    } else if (app_.graph.node(*node).external) {
      problems_.add(value.place, key, "an external node is not scheduled, so it has no callback",
                    fmt::format("leave {}: out, or external: true", key_));
    } else if (std::none_of(list_.begin(), list_.end(), [&](const auto& one) { return one.node == *node; })) {
      check_single(*node, *callback, key);
      list_.push_back({*node, std::move(*callback)});
    }
  }

  // What a whole app file says, whose shape is right: the app has been read from it.
  void add_app_file(const Value& root) {
    const Value* const nodes = value_at(root, "nodes");
    if (nodes == nullptr) return;
    for (const Entry& entry : nodes->entries) {
      const Value* const value = value_at(entry.value, key_);
      if (value != nullptr) add(entry, *value, join_key(join_key("nodes", entry.key), key_));
    }
  }

  // In the order of the app's nodes.
  std::vector<CallbackBinding<Callback>> take() {
    std::sort(list_.begin(), list_.end(), [](const auto& a, const auto& b) { return a.node.index() < b.node.index(); });
    return std::move(list_);
  }

 private:
  static const Value* value_at(const Value& map, std::string_view key) {
    const auto found =
        std::find_if(map.entries.begin(), map.entries.end(), [&](const Entry& entry) { return entry.key == key; });
    return found == map.entries.end() ? nullptr : &found->value;
  }

  void check_single(NodeId node, const Callback& callback, const std::string& key) {
    const auto other =
        std::find_if(list_.begin(), list_.end(), [&](const auto& one) { return one.callback.same_as(callback); });
    if (other == list_.end()) return;
    problems_.add(callback.place, key,
                  fmt::format("nodes {} and {} are the same callback", quote(app_.graph.node(other->node).name),
                              quote(app_.graph.node(node).name)),
                  "a callback is one node: remove one of the two");
  }

  const std::string key_;
  const Read read_;
  const graph::App& app_;
  Problems& problems_;
  std::vector<CallbackBinding<Callback>> list_;
};

// What an app file says at the nodes' `key`, which has been read as `app`, in the order of its nodes. Errors (kCaller):
// two nodes are one callback; a node that is external has one; as `read` has them.
template <class Callback>
Result<std::vector<CallbackBinding<Callback>>> callbacks_of_app_file(std::string_view text, std::string_view file,
                                                                     const graph::App& app, std::string key,
                                                                     typename CollectedCallbacks<Callback>::Read read) {
  const auto root = parse_yaml(text, file, "docs/app-file.md");
  if (!root) return root.error();
  Problems problems;
  CollectedCallbacks<Callback> collected(std::move(key), read, app, problems);
  collected.add_app_file(*root);
  if (!problems.empty()) return std::move(problems).to_error();
  return collected.take();
}

}  // namespace ctn::config
