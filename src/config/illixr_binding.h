// Which threadloop or callback of an ILLIXR plugin is which node of an app (docs/illixr.md): `illixr:` of a node in the
// app file,
//
//   illixr: { plugin: offline_imu }                     the plugin's threadloop
//   illixr: { plugin: rk4_integrator, topic: imu }      what it has the switchboard call for that topic
//   illixr: { plugin: offline_cam, output: [cam] }      gives output where it puts something on one of these topics
//
// Whether there are such plugins only the running program knows.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "config/callback_binding.h"
#include "config/problems.h"
#include "config/yaml.h"
#include "graph/app.h"

namespace ctn::config {

struct IllixrCallback {
  std::string plugin;
  std::string topic;                 // empty: its threadloop
  std::vector<std::string> outputs;  // topics; empty: any
  Place place;

  bool same_as(const IllixrCallback& other) const { return plugin == other.plugin && topic == other.topic; }
};

using IllixrBinding = CallbackBinding<IllixrCallback>;

// `value` is what stands at `key`.
std::optional<IllixrCallback> read_illixr_callback(const Value& value, const std::string& key, Problems& problems);

// Of a whole app file, whose shape is right.
std::vector<IllixrBinding> read_illixr_bindings(const Value& root, const graph::App& app, Problems& problems);

// What an app file says, which has been read as `app`, in the order of its nodes. Errors (kCaller): two nodes are one
// callback; a node that is external has one.
Result<std::vector<IllixrBinding>> illixr_bindings(std::string_view app_text, std::string_view file,
                                                   const graph::App& app);

}  // namespace ctn::config
