// A plan as the thread configuration of Autoware's callback-isolated executor: which priority and which CPUs the thread
// of each callback group has (docs/ros2.md). That executor gives each callback group of ROS 2 a thread, and calls
// callbacks as messages and timers come: it knows priorities and CPUs, but neither rates nor triggers, and what the
// plan has of these is written as comments. A subchain that is called more often than its CPU can run it, where the
// plan would have kept it to a rate, gets an ordinary thread: at a fixed priority it would leave nothing to others.
//
// A callback group is known by its ID, made of all callbacks in it. Its own tool writes a template with the IDs of all
// groups of a running system; without one, each callback is taken to be alone in its group.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "config/ros_binding.h"
#include "config/yaml.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::tool {

struct CieTemplate {
  std::string file;  // for errors
  config::Value root;
};

// Errors (kCaller): all that is wrong with the text.
Result<CieTemplate> parse_cie_template(const std::string& text, const std::string& file);

struct CieConfiguration {
  std::string text;                // YAML
  std::vector<std::string> notes;  // what the user should know of it, a sentence each
};

// `cpus` are the CPU numbers of the plan's cores. Precondition: no core of the plan has frames that several subchains
// share. Errors (kCaller): callbacks that no group of the template has, or that several have.
Result<CieConfiguration> cie_configuration(const plan::Plan& plan, const graph::App& app,
                                           const std::vector<config::RosBinding>& bindings,
                                           const std::vector<int>& cpus, const std::optional<CieTemplate>& from);

}  // namespace ctn::tool
