#include "common/inferred_app.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

namespace catan_ros {
namespace {

using std::chrono::nanoseconds;

// Half of the runs are below that of a callback that does no more than keep a message.
constexpr nanoseconds kKeepsOnly = std::chrono::microseconds{300};
constexpr nanoseconds kMinCost = std::chrono::microseconds{1};
// Of a node's runs that publish a topic, where its reader is to run at its rate.
constexpr double kAlmostAll = 0.9;
constexpr std::size_t kRunsForAPeriod = 10;
// A tenth of the intervals may be that part of the median away from it, where there is a clock.
constexpr double kRegular = 0.25;
constexpr std::size_t kMaxName = 90;
constexpr std::array<std::string_view, 5> kNoData{"/rosout", "/rosout_agg", "/clock", "/tf", "/tf_static"};

bool is_data(const std::string& topic) { return std::find(kNoData.begin(), kNoData.end(), topic) == kNoData.end(); }

bool contains(const std::vector<std::string>& list, const std::string& one) {
  return std::find(list.begin(), list.end(), one) != list.end();
}

// --- Figures ---

// Precondition: there are some.
nanoseconds percentile(std::vector<nanoseconds> values, double part) {
  const auto rank = static_cast<std::size_t>(std::ceil(part * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<nanoseconds> costs_of(const ObservedCallback& callback) {
  std::vector<nanoseconds> costs;
  for (const ObservedRun& run : callback.runs) costs.push_back(run.cpu_time);
  return costs;
}

std::vector<nanoseconds> intervals(std::vector<nanoseconds> times) {
  std::sort(times.begin(), times.end());
  std::adjacent_difference(times.begin(), times.end(), times.begin());
  if (!times.empty()) times.erase(times.begin());
  return times;
}

std::vector<nanoseconds> begins_of(const ObservedCallback& callback) {
  std::vector<nanoseconds> begins;
  for (const ObservedRun& run : callback.runs) begins.push_back(run.begin);
  return begins;
}

// With three decimals at most.
std::string decimal(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f", value);
  std::string shown = text.data();
  shown.erase(shown.find_last_not_of('0') + 1);
  if (shown.back() == '.') shown.pop_back();
  return shown;
}

double in_ms(nanoseconds time) { return static_cast<double>(time.count()) * 1e-6; }
std::string duration_text(nanoseconds time) { return decimal(in_ms(std::max(time, kMinCost))) + "ms"; }
// What roscpp compares periods with: to the nanosecond.
std::string exact_text(nanoseconds time) {
  if (time.count() % 1'000'000 == 0) return std::to_string(time.count() / 1'000'000) + "ms";
  if (time.count() % 1'000 == 0) return std::to_string(time.count() / 1'000) + "us";
  return std::to_string(time.count()) + "ns";
}
std::string rate_text(nanoseconds period) {
  return decimal(std::max(1e9 / static_cast<double>(period.count()), 0.001)) + "Hz";
}

// --- The graph ---

struct Vertex {
  const ObservedCallback* callback = nullptr;  // null: external
  std::string topic{};                         // of an external one
  std::vector<std::string> ros_nodes{};        // that an external one stands for
  std::optional<nanoseconds> period{};
  std::string name{};

  bool external() const { return callback == nullptr; }
};

struct Edge {
  std::size_t from = 0;
  std::size_t to = 0;
  std::string topic{};
  bool kept = false;      // by a callback that is no node, or does not publish: it is assumed that it is used
  std::size_t count = 0;  // of messages
};

using Indices = std::vector<std::size_t>;

class Inference {
 public:
  Inference(const std::vector<ObservedCallback>& callbacks, const Connections& connections)
      : callbacks_(callbacks), connections_(connections) {}

  InferredApp infer(const std::string& name);

 private:
  void find_nodes();
  Indices publishing_siblings(const ObservedCallback& callback) const;
  void add_edges_to(const ObservedCallback& reader, const Indices& targets, bool kept);
  void add_edges_out();
  std::size_t external(const std::string& topic, bool begins);
  void add_edge(std::size_t from, std::size_t to, const std::string& topic, bool kept, std::size_t count);
  bool reaches(std::size_t from, std::size_t to) const;
  void take_edges();
  void name_vertices();
  void sort_vertices();
  void find_subchains();
  std::optional<std::size_t> next_in_row(std::size_t vertex) const;
  std::vector<Indices> chains() const;
  Indices heaviest(std::size_t vertex, bool forwards) const;
  bool in_subchain_behind_head(std::size_t vertex) const;
  void tell_spinners();

  std::string nodes_text() const;
  std::string node_text(std::size_t vertex) const;
  std::string objective_text() const;
  std::string path_text(const Indices& path, const char* between) const;

  const std::vector<ObservedCallback>& callbacks_;
  const Connections& connections_;
  std::vector<Vertex> vertices_;
  std::map<const ObservedCallback*, std::size_t> vertex_of_;
  std::vector<Edge> found_;  // in any order
  std::vector<Edge> edges_;  // those that form no cycle
  std::vector<Indices> subchains_;
  Indices order_;  // from sources to sinks
  std::vector<std::string> remarks_;
};

bool publishes(const ObservedCallback& callback) {
  return std::any_of(callback.runs.begin(), callback.runs.end(), [](const ObservedRun& run) {
    return std::any_of(run.published.begin(), run.published.end(), is_data);
  });
}

std::size_t count_published(const ObservedCallback& callback, const std::string& topic) {
  return static_cast<std::size_t>(
      std::count_if(callback.runs.begin(), callback.runs.end(),
                    [&](const ObservedRun& run) { return contains(run.published, topic); }));
}

std::string described(const ObservedCallback& callback) {
  if (callback.kind == Binding::Kind::kTimer) return callback.ros_node + "'s timer of " + exact_text(callback.period);
  return callback.ros_node + "'s " + (callback.kind == Binding::Kind::kTopic ? "subscription of " : "service ") +
         callback.name;
}

bool same_callback(const ObservedCallback& a, const ObservedCallback& b) {
  return a.ros_node == b.ros_node && a.kind == b.kind && a.name == b.name && a.period == b.period;
}

bool is_light(const ObservedCallback& callback) {
  return !publishes(callback) && percentile(costs_of(callback), 0.5) < kKeepsOnly;
}

// Callbacks that can be nodes, without those that only keep messages.
void Inference::find_nodes() {
  std::vector<const ObservedCallback*> candidates;
  for (const ObservedCallback& callback : callbacks_) {
    if (callback.kind == Binding::Kind::kTopic && !is_data(callback.name)) continue;
    const bool again = std::any_of(candidates.begin(), candidates.end(),
                                   [&](const ObservedCallback* one) { return same_callback(*one, callback); });
    if (callback.kind == Binding::Kind::kService) {
      if (!callback.runs.empty()) remarks_.push_back(described(callback) + " is left as it is; bind it if it matters");
    } else if (again) {
      remarks_.push_back(described(callback) + " is there more than once; the first is the node");
    } else if (callback.runs.empty()) {
      remarks_.push_back(described(callback) + " was not called");
    } else {
      candidates.push_back(&callback);
    }
  }
  for (const ObservedCallback* const callback : candidates) {
    const bool has_publisher = std::any_of(candidates.begin(), candidates.end(), [&](const ObservedCallback* other) {
      return other->ros_node == callback->ros_node && publishes(*other);
    });
    if (is_light(*callback) && callback->kind == Binding::Kind::kTimer) {
      remarks_.push_back(described(*callback) + " publishes nothing and takes next to no time: it is left as it is");
      continue;
    }
    if (is_light(*callback) && has_publisher) continue;
    vertex_of_[callback] = vertices_.size();
    Vertex& vertex = vertices_.emplace_back();
    vertex.callback = callback;
    const std::vector<nanoseconds> between = intervals(begins_of(*callback));
    if (!between.empty()) vertex.period = percentile(between, 0.5);
    if (callback->kind == Binding::Kind::kTimer) vertex.period = callback->period;
  }
}

// Who uses what the callback keeps: timers of its program, else its other callbacks that publish.
Indices Inference::publishing_siblings(const ObservedCallback& callback) const {
  Indices timers;
  Indices all;
  for (const auto& [other, vertex] : vertex_of_) {
    if (other == &callback || other->ros_node != callback.ros_node || !publishes(*other)) continue;
    all.push_back(vertex);
    if (other->kind == Binding::Kind::kTimer) timers.push_back(vertex);
  }
  Indices& found = timers.empty() ? all : timers;
  std::sort(found.begin(), found.end());
  return found;
}

void Inference::add_edge(std::size_t from, std::size_t to, const std::string& topic, bool kept, std::size_t count) {
  if (from == to) return;
  const auto known =
      std::find_if(found_.begin(), found_.end(), [&](const Edge& edge) { return edge.from == from && edge.to == to; });
  if (known == found_.end()) {
    found_.push_back({from, to, topic, kept, count});
  } else if (known->kept && !kept) {
    *known = {from, to, topic, kept, count};
  }
}

std::size_t Inference::external(const std::string& topic, bool begins) {
  for (std::size_t index = 0; index < vertices_.size(); ++index) {
    if (vertices_[index].topic == topic) return index;
  }
  Vertex& vertex = vertices_.emplace_back();
  vertex.topic = topic;
  const auto& nodes = begins ? connections_.publishers : connections_.subscribers;
  if (const auto known = nodes.find(topic); known != nodes.end()) vertex.ros_nodes = known->second;
  return vertices_.size() - 1;
}

// The period of what comes regularly.
std::optional<nanoseconds> clock_of(const std::vector<nanoseconds>& times) {
  if (times.size() < kRunsForAPeriod) return std::nullopt;
  const std::vector<nanoseconds> between = intervals(times);
  const nanoseconds median = percentile(between, 0.5);
  const auto off = std::chrono::duration_cast<nanoseconds>(median * kRegular);
  const bool regular = percentile(between, 0.1) >= median - off && percentile(between, 0.9) <= median + off;
  return regular && median >= kMinCost ? std::optional(median) : std::nullopt;
}

// From whoever sends what `reader` was called with, to those that use it.
void Inference::add_edges_to(const ObservedCallback& reader, const Indices& targets, bool kept) {
  std::set<std::string> sent_by_nodes;
  for (const auto& [sender, vertex] : vertex_of_) {
    const std::size_t count = count_published(*sender, reader.name);
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
void Inference::add_edges_out() {
  for (std::size_t from = 0, count = vertices_.size(); from < count; ++from) {
    if (vertices_[from].external()) continue;
    std::set<std::string> topics;
    for (const ObservedRun& run : vertices_[from].callback->runs)
      topics.insert(run.published.begin(), run.published.end());
    for (const std::string& topic : topics) {
      const bool is_read = std::any_of(callbacks_.begin(), callbacks_.end(), [&](const ObservedCallback& callback) {
        return callback.kind == Binding::Kind::kTopic && callback.name == topic;
      });
      const auto readers = connections_.subscribers.find(topic);
      if (is_read || !is_data(topic) || readers == connections_.subscribers.end() || readers->second.empty()) continue;
      add_edge(from, external(topic, false), topic, false, count_published(*vertices_[from].callback, topic));
    }
  }
}

bool Inference::reaches(std::size_t from, std::size_t to) const {
  if (from == to) return true;
  return std::any_of(edges_.begin(), edges_.end(),
                     [&](const Edge& edge) { return edge.from == from && reaches(edge.to, to); });
}

// The surest first: messages that were published and taken, of these the most frequent.
void Inference::take_edges() {
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

std::string last_part(const std::string& name) { return name.substr(name.rfind('/') + 1); }

// Of the ROS node, with the callback where there are several, or of the topic.
void Inference::name_vertices() {
  std::map<std::string, int> of_ros_node;
  for (const Vertex& vertex : vertices_) {
    if (!vertex.external()) ++of_ros_node[vertex.callback->ros_node];
  }
  std::set<std::string> taken;
  for (Vertex& vertex : vertices_) {
    std::string name = vertex.external() ? vertex.topic.substr(1) : vertex.callback->ros_node.substr(1);
    if (!vertex.external() && of_ros_node[vertex.callback->ros_node] > 1) {
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
void Inference::sort_vertices() {
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

// --- Subchains and chains ---

// The node that takes this one's output alone, and is the only one to take it.
std::optional<std::size_t> Inference::next_in_row(std::size_t vertex) const {
  const auto is_out = [&](const Edge& edge) { return edge.from == vertex && !vertices_[edge.to].external(); };
  if (vertices_[vertex].external() || std::count_if(edges_.begin(), edges_.end(), is_out) != 1) return std::nullopt;
  const Edge& out = *std::find_if(edges_.begin(), edges_.end(), is_out);
  const ObservedCallback& from = *vertices_[vertex].callback;
  const ObservedCallback& to = *vertices_[out.to].callback;
  const bool only =
      std::count_if(edges_.begin(), edges_.end(), [&](const Edge& edge) { return edge.to == out.to; }) == 1;
  const auto published = static_cast<double>(count_published(from, out.topic));
  const bool always = published >= kAlmostAll * static_cast<double>(from.runs.size());
  const bool by_message = !out.kept && to.kind == Binding::Kind::kTopic && to.name == out.topic;
  return only && always && by_message ? std::optional(out.to) : std::nullopt;
}

void Inference::find_subchains() {
  std::vector<bool> placed(vertices_.size(), false);
  for (const std::size_t head : order_) {
    if (placed[head]) continue;
    Indices row{head};
    while (const auto next = next_in_row(row.back())) row.push_back(*next);
    if (row.size() == 1) continue;
    for (const std::size_t vertex : row) placed[vertex] = true;
    subchains_.push_back(std::move(row));
  }
}

bool Inference::in_subchain_behind_head(std::size_t vertex) const {
  return std::any_of(subchains_.begin(), subchains_.end(),
                     [&](const Indices& row) { return std::find(row.begin() + 1, row.end(), vertex) != row.end(); });
}

nanoseconds cost_of(const Vertex& vertex) {
  return vertex.external() ? nanoseconds{0} : std::max(percentile(costs_of(*vertex.callback), 0.95), kMinCost);
}

// From the vertex on, itself included, the path that computes longest; of equals the longer one.
Indices Inference::heaviest(std::size_t vertex, bool forwards) const {
  const auto measure = [this](const Indices& path) {
    nanoseconds sum{0};
    for (const std::size_t index : path) sum += cost_of(vertices_[index]);
    return std::pair(sum, path.size());
  };
  std::vector<Indices> from(vertices_.size());
  const auto best_from = [&](std::size_t at) {
    Indices best;
    for (const Edge& edge : edges_) {
      if ((forwards ? edge.from : edge.to) != at) continue;
      const Indices& rest = from[forwards ? edge.to : edge.from];
      if (best.empty() || measure(rest) > measure(best)) best = rest;
    }
    best.insert(best.begin(), at);
    return best;
  };
  Indices order = order_;
  if (forwards) std::reverse(order.begin(), order.end());
  for (const std::size_t at : order) {
    from[at] = best_from(at);
    if (at == vertex) break;
  }
  return from[vertex];
}

// One through every node.
std::vector<Indices> Inference::chains() const {
  std::vector<Indices> all;
  std::set<std::size_t> covered;
  Indices by_cost = order_;
  std::stable_sort(by_cost.begin(), by_cost.end(),
                   [this](std::size_t a, std::size_t b) { return cost_of(vertices_[a]) > cost_of(vertices_[b]); });
  for (const std::size_t vertex : by_cost) {
    if (vertices_[vertex].external() || covered.count(vertex) > 0) continue;
    Indices path = heaviest(vertex, false);
    std::reverse(path.begin(), path.end());
    const Indices rest = heaviest(vertex, true);
    path.insert(path.end(), rest.begin() + 1, rest.end());
    covered.insert(path.begin(), path.end());
    all.push_back(std::move(path));
  }
  return all;
}

// Nodes that all ran in one thread wait for each other, which the plan does not know.
void Inference::tell_spinners() {
  std::map<std::pair<std::string, std::int64_t>, Indices> of_thread;
  for (const std::size_t vertex : order_) {
    if (vertices_[vertex].external()) continue;
    const ObservedCallback& callback = *vertices_[vertex].callback;
    const std::int64_t thread = callback.runs.front().thread;
    const bool one = std::all_of(callback.runs.begin(), callback.runs.end(),
                                 [&](const ObservedRun& run) { return run.thread == thread; });
    if (one) of_thread[{callback.ros_node, thread}].push_back(vertex);
  }
  for (const auto& [thread, nodes] : of_thread) {
    if (nodes.size() < 2) continue;
    remarks_.push_back(path_text(nodes, ", ") + " share a spinner of " + thread.first +
                       ": their runs never overlap, which the plan does not know");
  }
}

// --- Text ---

std::string Inference::path_text(const Indices& path, const char* between) const {
  std::string text;
  for (const std::size_t vertex : path) {
    if (!text.empty()) text += between;
    text += vertices_[vertex].name;
  }
  return text;
}

std::string joined(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& one : list) text += (text.empty() ? "" : ", ") + one;
  return text;
}

std::string Inference::node_text(std::size_t index) const {
  const Vertex& vertex = vertices_[index];
  if (vertex.external()) {
    const std::string clock = vertex.period ? ", period: " + duration_text(*vertex.period) : "";
    const std::string who = vertex.ros_nodes.empty() ? "" : " of " + joined(vertex.ros_nodes);
    return "  " + vertex.name + ": { external: true" + clock + " }   # " + vertex.topic + who + "\n";
  }
  const ObservedCallback& callback = *vertex.callback;
  const bool is_timer = callback.kind == Binding::Kind::kTimer;
  std::string text = "  " + vertex.name + ": { ";
  if (vertex.period && !in_subchain_behind_head(index)) text += "fallback_rate: " + rate_text(*vertex.period) + ", ";
  if (is_timer) text += "max_rate: " + rate_text(*vertex.period) + ", ";
  text += "ros: { node: " + callback.ros_node +
          (is_timer ? ", timer: " + exact_text(callback.period) : ", topic: " + callback.name) + " } }   # ";
  if (!callback.type.empty()) text += callback.type + ", ";
  return text + std::to_string(callback.runs.size()) + (callback.runs.size() == 1 ? " run\n" : " runs\n");
}

std::string Inference::nodes_text() const {
  std::string text = "nodes:\n";
  for (const std::size_t vertex : order_) text += node_text(vertex);
  if (!edges_.empty()) text += "edges:\n";
  for (const std::size_t from : order_) {
    for (const Edge& edge : edges_) {
      if (edge.from != from) continue;
      text += "  - " + vertices_[from].name + " -> " + vertices_[edge.to].name + "   # " + edge.topic +
              (edge.kept ? ", assumed: kept until it runs\n" : "\n");
    }
  }
  if (!subchains_.empty()) text += "subchains:   # run at one rate, each node triggering the next\n";
  for (const Indices& row : subchains_) {
    text += "  " + vertices_[row.front()].name + "_to_" + last_part("/" + vertices_[row.back()].name) + ": [" +
            path_text(row, ", ") + "]\n";
  }
  return text;
}

std::string Inference::objective_text() const {
  std::string text =
      "objective:   # the weights are yours to set: what a millisecond of each counts; remove what does not matter\n";
  for (const Indices& path : chains()) {
    if (path.size() == 1) {
      text += "  - { period: " + vertices_[path[0]].name + ", weight: 1 }\n";
    } else {
      text += "  - { response_time: [" + path_text(path, ", ") + "], weight: 1 }\n";
    }
  }
  return text;
}

InferredApp Inference::infer(const std::string& name) {
  InferredApp inferred;
  find_nodes();
  inferred.nodes = vertices_.size();
  if (vertices_.empty()) return inferred;
  for (const ObservedCallback& callback : callbacks_) {
    if (callback.kind != Binding::Kind::kTopic || callback.runs.empty() || !is_data(callback.name)) continue;
    const auto own = vertex_of_.find(&callback);
    if (own == vertex_of_.end()) {
      add_edges_to(callback, publishing_siblings(callback), true);
      continue;
    }
    add_edges_to(callback, {own->second}, false);
    if (publishes(callback)) continue;
    for (const std::size_t sibling : publishing_siblings(callback)) {
      add_edge(own->second, sibling, "within " + callback.ros_node, true, callback.runs.size());
    }
  }
  add_edges_out();
  name_vertices();
  take_edges();
  sort_vertices();
  find_subchains();
  tell_spinners();

  inferred.app = "# Written by catan ros bind, from what running programs did. Check it, set the weights, then plan.\n";
  for (const std::string& remark : remarks_) inferred.app += "# - " + remark + "\n";
  inferred.app += "catan: 1\napp: " + name + "\n" + nodes_text() + objective_text();
  inferred.costs = "# Written by catan ros bind: CPU time of a run, 95 % and half of the runs below it.\n";
  for (const std::size_t vertex : order_) {
    if (vertices_[vertex].external()) continue;
    const nanoseconds typical = percentile(costs_of(*vertices_[vertex].callback), 0.5);
    inferred.costs += vertices_[vertex].name + ": { cost: " + duration_text(cost_of(vertices_[vertex])) +
                      ", typical: " + duration_text(typical) + " }\n";
  }
  inferred.remarks = remarks_;
  return inferred;
}

}  // namespace

InferredApp infer_app(const std::vector<ObservedCallback>& callbacks, const Connections& connections,
                      const std::string& name) {
  return Inference(callbacks, connections).infer(name);
}

}  // namespace catan_ros
