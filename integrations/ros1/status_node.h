// The ROS node of `catan ros node`, in a library of its own (libcatan_ros1_node.so) that the command loads. Both are
// built together. What it publishes: docs/ros1.md.
#pragma once

#include "common/shown_app.h"

namespace catan_ros {

// `argc`, `argv`: what ROS is told (remappings). Settings can be changed where `allow_control` says so. Waits for the
// master, and returns when the node is told to end, by a signal or by ROS.
using RunStatusNode = void (*)(int& argc, char** argv, ShownApp& app, bool allow_control);
constexpr const char* kRunStatusNode = "catan_ros1_run_status_node";
constexpr const char* kStatusNodeLibrary = "libcatan_ros1_node.so";

}  // namespace catan_ros
