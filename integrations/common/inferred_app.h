// From what was seen of running ROS programs to a first app file: nodes, edges, subchains, external sensors, bindings
// and costs. What matters of it, only its user knows: all weights are 1.
//
// A callback of a topic or timer that has run is a node. An edge is a message: a node published it in a run, another
// was called with it. A light callback that publishes nothing, in a program with one that does, only keeps what it
// gets: it is no node, and what it gets goes to those that publish (its timers, if there are any). A program is a ROS
// node, or a nodelet of one. Nor is a light timer
// that publishes nothing. A topic that no observed callback publishes comes from an external node; one that only others
// take ends in one.
//
// Edges form no cycle: they are added from the surest on, as long as none closes one. Nodes in a row, where each takes
// the output of the one before alone, and that goes to it alone, are a subchain. The objective has a chain through
// every node: the one that computes longest.
//
// Thread safety: pure functions, plain values.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/inferred_graph.h"
#include "common/observation.h"

namespace catan_ros {

struct InferredApp {
  std::string app{};                   // the app file's text
  std::string costs{};                 // the cost file's
  std::vector<std::string> remarks{};  // what was left out, and why; in the app file, too
  std::size_t nodes = 0;               // that are not external
};

// `name` is the app's.
InferredApp infer_app(const std::vector<ObservedCallback>& callbacks, const Connections& connections,
                      const std::string& name);

}  // namespace catan_ros
