// The graph that is inferred from what callbacks were seen to do (inferred_app.h says how): its nodes, those that are
// external, and edges without a cycle. A program is a ROS node, or a nodelet of one: what is kept there is used there.
//
// Thread safety: plain values.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
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
  // Of a callback of messages whose senders all have a clock: it need not run more often.
  std::optional<std::chrono::nanoseconds> min_period{};
  bool takes_all = false;  // a message that is passed over would be missed: by those that come with it, or at all
  std::vector<std::string> publishers{};  // programs that send what a callback of messages gets
  // Where any of several callbacks may complete a set of messages: the first topic that the set is published on. Empty:
  // it is none of these.
  std::string set{};
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

  // `callbacks` outlive it; those of one name are called at a time (repeated_callbacks.h).
  InferredGraph(const std::vector<ObservedCallback>& callbacks, const Connections& connections);

  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<Edge>& edges() const { return edges_; }
  // All vertices, each behind all that it takes from.
  const Indices& order() const { return order_; }
  // What was left out, and why.
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  using Callbacks = std::vector<const ObservedCallback*>;

  void find_candidates();
  Callbacks called_alike(const ObservedCallback& callback) const;
  bool is_candidate(const ObservedCallback& callback) const;
  void find_sets();
  void find_set(Callbacks callbacks, const std::string& topic);
  Callbacks keepers_beside(const Callbacks& publishing) const;
  bool sent_by_one(const Callbacks& callbacks) const;
  bool sends(const ObservedCallback& callback) const;  // itself, or it might have for its set
  std::size_t count_sent(const ObservedCallback& callback, const std::string& topic) const;
  std::set<std::string> sent_topics(const ObservedCallback& callback) const;
  std::set<const ObservedCallback*> senders_before(const ObservedCallback& callback) const;
  Callbacks senders_to(const ObservedCallback& callback) const;
  std::vector<std::string> publishers_to(const ObservedCallback& callback) const;
  bool is_behind(const ObservedCallback& callback, const ObservedCallback& other) const;
  bool keeps_for_another(const ObservedCallback& callback) const;
  bool completes_sets(const ObservedCallback& callback) const;
  void find_nodes();
  void find_edges();
  Indices users_of(const ObservedCallback& callback) const;
  Indices publishing_siblings(const ObservedCallback& callback) const;
  void add_edges_to(const ObservedCallback& reader, const Indices& targets, bool kept);
  void add_edges_out();
  std::size_t external(const std::string& topic, bool begins);
  void add_edge(std::size_t from, std::size_t to, const std::string& topic, bool kept, std::size_t count);
  bool reaches(std::size_t from, std::size_t to) const;
  void take_edges();
  void name_vertices();
  void sort_vertices();
  void bound_rates();

  const std::vector<ObservedCallback>& callbacks_;
  const Connections& connections_;
  Callbacks candidates_;  // that can be nodes, one of a name
  std::vector<Vertex> vertices_;
  std::map<const ObservedCallback*, std::size_t> vertex_of_;
  std::map<std::string, Callbacks> publishing_;  // by topic
  // Callbacks that keep a message for a set, and the one that completes it.
  std::map<const ObservedCallback*, const ObservedCallback*> completed_by_;
  std::set<const ObservedCallback*> any_completes_;  // of sets that now one of these completes, now another
  // What these sets publish, and how often: each of their callbacks may, also one that did not while it was observed.
  std::map<const ObservedCallback*, std::map<std::string, std::size_t>> set_publishes_;
  std::vector<Edge> found_;  // in any order
  std::vector<Edge> edges_;  // those that form no cycle
  Indices order_;
  std::vector<std::string> remarks_;
};

// What is behind the last slash.
std::string last_part(const std::string& name);

}  // namespace catan_ros
