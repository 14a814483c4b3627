#include "common/inferred_graph.h"

#include <algorithm>
#include <set>

#include "common/observed_figures.h"
#include "common/repeated_callbacks.h"

namespace catan_ros {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMaxName = 90;
// How much more often than messages come a callback may run: so that one that was late once runs as soon as its message
// is there again, some runs later.
constexpr double kCatchesUp = 1.1;

bool contains(const std::vector<std::string>& list, const std::string& one) {
  return std::find(list.begin(), list.end(), one) != list.end();
}

double seconds_of(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

std::string last_part(const std::string& name) { return name.substr(name.rfind('/') + 1); }

InferredGraph::InferredGraph(const std::vector<ObservedCallback>& callbacks, const Connections& connections)
    : callbacks_(callbacks), connections_(connections) {
  find_candidates();
  find_sets();
  find_nodes();
  find_edges();
  name_vertices();
  take_edges();
  sort_vertices();
  bound_rates();
}

// Callbacks of one program that have one name at a time cannot be told apart by a binding, which names the first
// (repeated_callbacks.h): were that one a node, the others would wait behind all nodes.
void InferredGraph::find_candidates() {
  std::set<const ObservedCallback*> others;  // of a name whose first one has been looked at
  for (const ObservedCallback& callback : callbacks_) {
    const bool called = !callback.runs.empty();
    if (callback.kind == Binding::Kind::kService) {
      if (called) remarks_.push_back(described(callback) + " is left as it is; bind it if it matters");
      continue;
    }
    if (!called) {
      remarks_.push_back(described(callback) + " was not called");
      continue;
    }
    if (others.count(&callback) > 0) continue;
    const Callbacks alike = called_alike(callback);
    others.insert(alike.begin(), alike.end());
    if (alike.size() == 1) {
      candidates_.push_back(&callback);
      continue;
    }
    remarks_.push_back(described(callback) + " is there " + std::to_string(alike.size()) +
                       " times, and which is which cannot be told: all are left as they are; in programs of their own "
                       "they can be nodes");
  }
}

// Those that were called, itself among them.
InferredGraph::Callbacks InferredGraph::called_alike(const ObservedCallback& callback) const {
  Callbacks alike;
  for (const ObservedCallback& other : callbacks_) {
    if (!other.runs.empty() && same_callback(callback, other)) alike.push_back(&other);
  }
  return alike;
}

bool InferredGraph::is_candidate(const ObservedCallback& callback) const {
  return std::find(candidates_.begin(), candidates_.end(), &callback) != candidates_.end();
}

bool InferredGraph::sends(const ObservedCallback& callback) const {
  return publishes(callback) || set_publishes_.count(&callback) > 0;
}

// What it publishes itself, or might have for its set.
std::size_t InferredGraph::count_sent(const ObservedCallback& callback, const std::string& topic) const {
  const std::size_t own = count_published(callback, topic);
  const auto sets = set_publishes_.find(&callback);
  if (sets == set_publishes_.end()) return own;
  const auto known = sets->second.find(topic);
  return known == sets->second.end() ? own : std::max(own, known->second);
}

std::set<std::string> InferredGraph::sent_topics(const ObservedCallback& callback) const {
  std::set<std::string> topics;
  for (const ObservedRun& run : callback.runs) topics.insert(run.published.begin(), run.published.end());
  const auto sets = set_publishes_.find(&callback);
  if (sets == set_publishes_.end()) return topics;
  for (const auto& [topic, count] : sets->second) topics.insert(topic);
  return topics;
}

// All whose messages reach it, by way of others too.
std::set<const ObservedCallback*> InferredGraph::senders_before(const ObservedCallback& callback) const {
  std::set<const ObservedCallback*> found;
  Callbacks readers{&callback};
  while (!readers.empty()) {
    const ObservedCallback& reader = *readers.back();
    readers.pop_back();
    for (const ObservedCallback* const sender : senders_to(reader)) {
      if (found.insert(sender).second) readers.push_back(sender);
    }
  }
  return found;
}

InferredGraph::Callbacks InferredGraph::senders_to(const ObservedCallback& callback) const {
  const auto senders = publishing_.find(callback.name);
  const bool none = callback.kind != Binding::Kind::kTopic || senders == publishing_.end();
  return none ? Callbacks() : senders->second;
}

// The programs whose messages it gets. Of several the newest message says nothing about those of the others, and what
// it takes the place of would be lost.
std::vector<std::string> InferredGraph::publishers_to(const ObservedCallback& callback) const {
  std::set<std::string> programs;
  std::set<std::string> observed;  // ROS nodes
  for (const ObservedCallback* const sender : senders_to(callback)) {
    programs.insert(program_of(*sender));
    observed.insert(sender->ros_node);
  }
  for (const ObservedRun& run : callback.runs) {
    if (!run.from.empty() && observed.count(run.from) == 0) programs.insert(run.from);
  }
  return {programs.begin(), programs.end()};
}

// Of the candidates, without those that only keep messages.
void InferredGraph::find_nodes() {
  for (const ObservedCallback* const callback : candidates_) {
    const bool has_publisher = std::any_of(candidates_.begin(), candidates_.end(), [&](const ObservedCallback* other) {
      return of_one_program(*other, *callback) && sends(*other);
    });
    if (is_light(*callback) && callback->kind == Binding::Kind::kTimer) {
      remarks_.push_back(described(*callback) + " publishes nothing and takes next to no time: it is left as it is");
      continue;
    }
    if (keeps_for_another(*callback)) {
      remarks_.push_back(described(*callback) + " is left as it is: its messages are used with those of " +
                         completed_by_[callback]->name + ", which come last");
      continue;
    }
    if (is_light(*callback) && has_publisher && !sends(*callback)) continue;
    vertex_of_[callback] = vertices_.size();
    Vertex& vertex = vertices_.emplace_back();
    vertex.callback = callback;
    vertex.publishers = publishers_to(*callback);
    const bool is_of_set = any_completes_.count(callback) > 0;
    vertex.takes_all = is_of_set || vertex.publishers.size() > 1;
    if (is_of_set) vertex.set = set_publishes_[callback].begin()->first;
    // Of several senders two messages may come at once, and then none for long.
    vertex.period = callback->kind == Binding::Kind::kTimer ? callback->period
                    : vertex.publishers.size() > 1          ? mean_interval(*callback)
                                                            : median_interval(*callback);
  }
}

void InferredGraph::find_edges() {
  for (const ObservedCallback* const candidate : candidates_) {
    const ObservedCallback& callback = *candidate;
    if (callback.kind != Binding::Kind::kTopic) continue;
    const auto own = vertex_of_.find(&callback);
    if (own == vertex_of_.end()) {
      add_edges_to(callback, users_of(callback), true);
      continue;
    }
    add_edges_to(callback, {own->second}, false);
    if (sends(callback)) continue;
    for (const std::size_t sibling : publishing_siblings(callback)) {
      add_edge(own->second, sibling, "within " + program_of(callback), true, callback.runs.size());
    }
  }
  add_edges_out();
}

// Who uses what the callback keeps.
InferredGraph::Indices InferredGraph::users_of(const ObservedCallback& callback) const {
  const auto completed = completed_by_.find(&callback);
  const auto user = completed == completed_by_.end() ? vertex_of_.end() : vertex_of_.find(completed->second);
  return user == vertex_of_.end() ? publishing_siblings(callback) : Indices{user->second};
}

// Timers of its program, else its other callbacks that publish. Where a program sends to itself, as one of nodelets
// does that are not told apart, what its messages go back to does not use them.
InferredGraph::Indices InferredGraph::publishing_siblings(const ObservedCallback& callback) const {
  const Callbacks senders = senders_to(callback);
  const bool sends_to_itself = std::any_of(senders.begin(), senders.end(), [&](const ObservedCallback* sender) {
    return of_one_program(*sender, callback);
  });
  const std::set<const ObservedCallback*> before =
      sends_to_itself ? senders_before(callback) : std::set<const ObservedCallback*>{};
  Indices timers;
  Indices all;
  for (const auto& [other, vertex] : vertex_of_) {
    if (other == &callback || !of_one_program(*other, callback)) continue;
    if (!sends(*other)) continue;
    if (before.count(other) > 0) continue;
    all.push_back(vertex);
    if (other->kind == Binding::Kind::kTimer) timers.push_back(vertex);
  }
  Indices& found = timers.empty() ? all : timers;
  std::sort(found.begin(), found.end());
  return found;
}

void InferredGraph::add_edge(std::size_t from, std::size_t to, const std::string& topic, bool kept, std::size_t count) {
  if (from == to) return;
  const auto known =
      std::find_if(found_.begin(), found_.end(), [&](const Edge& edge) { return edge.from == from && edge.to == to; });
  if (known == found_.end()) {
    found_.push_back({from, to, topic, kept, count});
  } else if (known->kept && !kept) {
    *known = {from, to, topic, kept, count};
  }
}

std::size_t InferredGraph::external(const std::string& topic, bool begins) {
  for (std::size_t index = 0; index < vertices_.size(); ++index) {
    if (vertices_[index].topic == topic) return index;
  }
  Vertex& vertex = vertices_.emplace_back();
  vertex.topic = topic;
  const auto& nodes = begins ? connections_.publishers : connections_.subscribers;
  if (const auto known = nodes.find(topic); known != nodes.end()) vertex.ros_nodes = known->second;
  return vertices_.size() - 1;
}

// From whoever sends what `reader` was called with, to those that use it.
void InferredGraph::add_edges_to(const ObservedCallback& reader, const Indices& targets, bool kept) {
  std::set<std::string> sent_by_nodes;
  for (const auto& [sender, vertex] : vertex_of_) {
    const std::size_t count = count_sent(*sender, reader.name);
    if (count == 0) continue;
    sent_by_nodes.insert(sender->ros_node);
    for (const std::size_t target : targets) add_edge(vertex, target, reader.name, kept, count);
  }
  std::vector<nanoseconds> from_others;
  std::vector<std::string> others;
  for (const ObservedRun& run : reader.runs) {
    if (sent_by_nodes.count(run.from) > 0 || (run.from.empty() && !sent_by_nodes.empty())) continue;
    from_others.push_back(run.begin);
    if (!run.from.empty() && !contains(others, run.from)) others.push_back(run.from);
  }
  if (from_others.empty() || targets.empty()) return;
  const std::size_t source = external(reader.name, true);
  Vertex& vertex = vertices_[source];
  for (std::string& other : others) {
    if (!contains(vertex.ros_nodes, other)) vertex.ros_nodes.push_back(std::move(other));
  }
  if (!vertex.period) vertex.period = clock_of(from_others);
  for (const std::size_t target : targets) add_edge(source, target, reader.name, kept, from_others.size());
}

// To those that are not observed and take what no observed callback takes.
void InferredGraph::add_edges_out() {
  for (std::size_t from = 0, count = vertices_.size(); from < count; ++from) {
    if (vertices_[from].external()) continue;
    for (const std::string& topic : sent_topics(*vertices_[from].callback)) {
      const bool is_read = std::any_of(callbacks_.begin(), callbacks_.end(), [&](const ObservedCallback& callback) {
        return callback.kind == Binding::Kind::kTopic && callback.name == topic;
      });
      const auto readers = connections_.subscribers.find(topic);
      if (is_read || readers == connections_.subscribers.end() || readers->second.empty()) continue;
      add_edge(from, external(topic, false), topic, false, count_sent(*vertices_[from].callback, topic));
    }
  }
}

bool InferredGraph::reaches(std::size_t from, std::size_t to) const {
  if (from == to) return true;
  return std::any_of(edges_.begin(), edges_.end(),
                     [&](const Edge& edge) { return edge.from == from && reaches(edge.to, to); });
}

// The surest first: messages that were published and taken, of these the most frequent.
void InferredGraph::take_edges() {
  std::stable_sort(found_.begin(), found_.end(), [this](const Edge& a, const Edge& b) {
    if (a.kept != b.kept) return b.kept;
    if (a.count != b.count) return a.count > b.count;
    return std::pair(vertices_[a.from].name, vertices_[a.to].name) <
           std::pair(vertices_[b.from].name, vertices_[b.to].name);
  });
  for (const Edge& edge : found_) {
    if (!reaches(edge.to, edge.from)) {
      edges_.push_back(edge);
      continue;
    }
    remarks_.push_back("the edge " + vertices_[edge.from].name + " -> " + vertices_[edge.to].name + " (" + edge.topic +
                       ") is left out: it would close a cycle");
  }
}

// Of the nodelet or ROS node, without its namespace unless another has the same name, with the callback where there are
// several; or of the topic.
void InferredGraph::name_vertices() {
  std::map<std::string, int> of_program;
  for (const Vertex& vertex : vertices_) {
    if (!vertex.external()) ++of_program[program_of(*vertex.callback)];
  }
  std::map<std::string, int> of_last_part;
  for (const auto& [program, vertices] : of_program) ++of_last_part[last_part(program)];
  std::set<std::string> taken;
  for (Vertex& vertex : vertices_) {
    std::string name = vertex.external() ? vertex.topic.substr(1) : last_part(program_of(*vertex.callback));
    if (!vertex.external() && of_last_part[name] > 1) name = program_of(*vertex.callback).substr(1);
    if (!vertex.external() && of_program[program_of(*vertex.callback)] > 1) {
      name += vertex.callback->kind == Binding::Kind::kTimer ? ".timer_" + exact_text(vertex.callback->period)
                                                             : "." + last_part(vertex.callback->name);
    }
    if (name.size() > kMaxName) name = name.substr(name.size() - kMaxName);
    std::string unique = name;
    for (int number = 2; !taken.insert(unique).second; ++number) unique = name + "_" + std::to_string(number);
    vertex.name = unique;
  }
}

// Each after all that it takes from; else as they were found.
void InferredGraph::sort_vertices() {
  std::vector<bool> placed(vertices_.size(), false);
  while (order_.size() < vertices_.size()) {
    for (std::size_t vertex = 0; vertex < vertices_.size(); ++vertex) {
      const bool waits = placed[vertex] || std::any_of(edges_.begin(), edges_.end(), [&](const Edge& edge) {
                           return edge.to == vertex && !placed[edge.from];
                         });
      if (waits) continue;
      placed[vertex] = true;
      order_.push_back(vertex);
    }
  }
}

// Of callbacks, from their senders on.
void InferredGraph::bound_rates() {
  std::vector<double> rates(vertices_.size(), 0.0);  // Hz, at most; 0: not known
  for (const std::size_t index : order_) {
    Vertex& vertex = vertices_[index];
    if (vertex.external() || vertex.callback->kind == Binding::Kind::kTimer) {
      if (vertex.period) rates[index] = 1.0 / seconds_of(*vertex.period);
      continue;
    }
    double rate = 0.0;
    std::map<std::string, double> of_sets;  // of callbacks of which one completes each
    bool known = true;
    for (const Edge& edge : edges_) {
      if (edge.to != index || edge.kept) continue;
      known = known && rates[edge.from] > 0.0;
      const std::string& set = vertices_[edge.from].set;
      if (set.empty()) {
        rate += rates[edge.from];
      } else {
        of_sets[set] = std::max(of_sets[set], rates[edge.from]);
      }
    }
    for (const auto& [set, most] : of_sets) rate += most;
    if (!known || rate <= 0.0) continue;
    rates[index] = rate;
    vertex.min_period = nanoseconds(static_cast<nanoseconds::rep>(1e9 / (kCatchesUp * rate)));
  }
}

}  // namespace catan_ros
