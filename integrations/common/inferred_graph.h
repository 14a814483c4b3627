// The graph that is inferred from what callbacks were seen to do (inferred_app.h says how): its nodes, those that are
// external, and edges without a cycle.
//
// Thread safety: plain values.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/observation.h"

namespace catan_ros {

// What the master knows: ROS nodes by topic.
struct Connections {
  std::map<std::string, std::vector<std::string>> publishers{};
  std::map<std::string, std::vector<std::string>> subscribers{};
};

struct Vertex {
  const ObservedCallback* callback = nullptr;  // null: external
  std::string topic{};                         // of an external one
  std::vector<std::string> ros_nodes{};        // that an external one stands for
  std::optional<std::chrono::nanoseconds> period{};
  std::string name{};

  bool external() const { return callback == nullptr; }
};

struct Edge {
  std::size_t from = 0;  // of vertices
  std::size_t to = 0;
  std::string topic{};
  bool kept = false;      // by a callback that is no node, or does not publish: it is assumed that it is used
  std::size_t count = 0;  // of messages
};

class InferredGraph {
 public:
  using Indices = std::vector<std::size_t>;

  // `callbacks` outlive it.
  InferredGraph(const std::vector<ObservedCallback>& callbacks, const Connections& connections);

  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<Edge>& edges() const { return edges_; }
  // All vertices, each behind all that it takes from.
  const Indices& order() const { return order_; }
  // What was left out, and why.
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  void find_nodes();
  void find_edges();
  Indices publishing_siblings(const ObservedCallback& callback) const;
  void add_edges_to(const ObservedCallback& reader, const Indices& targets, bool kept);
  void add_edges_out();
  std::size_t external(const std::string& topic, bool begins);
  void add_edge(std::size_t from, std::size_t to, const std::string& topic, bool kept, std::size_t count);
  bool reaches(std::size_t from, std::size_t to) const;
  void take_edges();
  void name_vertices();
  void sort_vertices();

  const std::vector<ObservedCallback>& callbacks_;
  const Connections& connections_;
  std::vector<Vertex> vertices_;
  std::map<const ObservedCallback*, std::size_t> vertex_of_;
  std::vector<Edge> found_;  // in any order
  std::vector<Edge> edges_;  // those that form no cycle
  Indices order_;
  std::vector<std::string> remarks_;
};

// What is behind the last slash.
std::string last_part(const std::string& name);

}  // namespace catan_ros
