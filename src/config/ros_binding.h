// Which callback of a ROS program is which node of an app (docs/ros1.md): `ros:` of a node in the app file, or a bind
// file apart,
//
//   catan: 1
//   ros:
//     GL: { node: /localiser, topic: /scan }
//     GP: { node: /planner, timer: 500ms }
//     map: { node: /mapper, service: /mapper/save }
//     turn: { node: /manager, nodelet: /turn, topic: /image }
//
// which holds for all nodes that it names; what the app file says of others stays. Whether there are such callbacks
// only the running programs know.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "config/callback_binding.h"
#include "config/problems.h"
#include "config/yaml.h"
#include "graph/app.h"

namespace ctn::config {

struct RosCallback {
  enum class Kind { kTopic, kTimer, kService };

  std::string node;     // the ROS node's full name: /mapper
  std::string nodelet;  // of it, in full; empty: any, or none
  Kind kind = Kind::kTopic;
  std::string name;  // of the topic or service, full; of a timer empty
  Nanos period{0};   // of a timer
  Place place;

  bool same_as(const RosCallback& other) const {
    return node == other.node && nodelet == other.nodelet && kind == other.kind && name == other.name &&
           period == other.period;
  }
};

using RosBinding = CallbackBinding<RosCallback>;

// `value` is what stands at `key`.
std::optional<RosCallback> read_ros_callback(const Value& value, const std::string& key, Problems& problems);

// Of a whole app file, whose shape is right.
std::vector<RosBinding> read_ros_bindings(const Value& root, const graph::App& app, Problems& problems);

// Of these, the nodes that are called for messages alone: callbacks of topics. Timers need none; a service's requests
// come from who asks, not from the nodes before it.
std::vector<NodeId> nodes_needing_input(const std::vector<RosBinding>& bindings);

// Errors (kCaller): one of these names a nodelet, of which ROS 2 has none.
Status check_without_nodelets(const std::vector<RosBinding>& bindings, const graph::App& app);

// Of ROS 1, where who calls a service waits for its answer within its own callback. Errors (kCaller): a service is
// behind a node of another program or nodelet in its subchain, or may be triggered by outputs of such a node, since its
// subchain does not have `trigger: time`. If that one calls it, both stand still: the service waits for the end of the
// run that waits for it.
Status check_services(const std::vector<RosBinding>& bindings, const graph::App& app);

// What an app file says, which has been read as `app`, in the order of its nodes. Errors (kCaller): two nodes are one
// callback; a node that is external has one.
Result<std::vector<RosBinding>> ros_bindings(std::string_view app_text, std::string_view file, const graph::App& app);

// The same with a bind file, which comes first. Errors besides: what is wrong with that file.
Result<std::vector<RosBinding>> ros_bindings(std::string_view app_text, std::string_view file, const graph::App& app,
                                             std::string_view bind_text, std::string_view bind_file);

}  // namespace ctn::config
