#include "common/inferred_app.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "common/observed_figures.h"
#include "common/repeated_callbacks.h"

namespace catan_ros {
namespace {

using std::chrono::nanoseconds;
using Indices = InferredGraph::Indices;

// Of a node's runs that publish a topic, where its reader is to run at its rate.
constexpr double kAlmostAll = 0.9;

nanoseconds cost_of(const Vertex& vertex) {
  return vertex.external() ? nanoseconds{0} : std::max(cost_percentile(*vertex.callback, 0.95), kMinCost);
}

std::string joined(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& one : list) text += (text.empty() ? "" : ", ") + one;
  return text;
}

// What is decided on top of the graph, and all of it as text.
class AppWriter {
 public:
  // `graph` outlives it; `remarks` come before its own.
  AppWriter(const InferredGraph& graph, std::vector<std::string> remarks)
      : graph_(graph), vertices_(graph.vertices()), edges_(graph.edges()), remarks_(std::move(remarks)) {
    remarks_.insert(remarks_.end(), graph.remarks().begin(), graph.remarks().end());
    find_subchains();
    find_spinners();
  }

  InferredApp write(const std::string& name) const;

 private:
  void find_subchains();
  std::optional<std::size_t> next_in_row(std::size_t vertex) const;
  bool in_subchain_behind_head(std::size_t vertex) const;
  std::vector<Indices> chains() const;
  Indices heaviest(std::size_t vertex, bool forwards) const;
  void find_spinners();

  std::string graph_text() const;
  std::string node_text(std::size_t index) const;
  std::string exclusive_text() const;
  std::string objective_text() const;
  std::string costs_text() const;
  std::string path_text(const Indices& path, const char* between) const;

  const InferredGraph& graph_;
  const std::vector<Vertex>& vertices_;
  const std::vector<Edge>& edges_;
  std::vector<std::string> remarks_;
  std::vector<Indices> subchains_;
  std::vector<Indices> spinners_;  // that several nodes share
};

// The node that takes this one's output alone, and is the only one to take it.
std::optional<std::size_t> AppWriter::next_in_row(std::size_t vertex) const {
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

void AppWriter::find_subchains() {
  std::vector<bool> placed(vertices_.size(), false);
  for (const std::size_t head : graph_.order()) {
    if (placed[head]) continue;
    Indices row{head};
    while (const auto next = next_in_row(row.back())) row.push_back(*next);
    if (row.size() == 1) continue;
    for (const std::size_t vertex : row) placed[vertex] = true;
    subchains_.push_back(std::move(row));
  }
}

bool AppWriter::in_subchain_behind_head(std::size_t vertex) const {
  return std::any_of(subchains_.begin(), subchains_.end(),
                     [&](const Indices& row) { return std::find(row.begin() + 1, row.end(), vertex) != row.end(); });
}

// From the vertex on, itself included, the path that computes longest; of equals the longer one.
Indices AppWriter::heaviest(std::size_t vertex, bool forwards) const {
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
  Indices order = graph_.order();
  if (forwards) std::reverse(order.begin(), order.end());
  for (const std::size_t at : order) {
    from[at] = best_from(at);
    if (at == vertex) break;
  }
  return from[vertex];
}

// One through every node.
std::vector<Indices> AppWriter::chains() const {
  std::vector<Indices> all;
  std::set<std::size_t> covered;
  Indices by_cost = graph_.order();
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

// Nodes that all ran in one thread wait for each other. So do a nodelet's, whichever of its manager's threads called
// them, where its queue calls one at a time; those of two nodelets do not, though one thread has called both.
void AppWriter::find_spinners() {
  std::map<std::tuple<std::string, std::string, std::int64_t>, Indices> of_thread;
  for (const std::size_t vertex : graph_.order()) {
    if (vertices_[vertex].external()) continue;
    const ObservedCallback& callback = *vertices_[vertex].callback;
    if (!callback.nodelet.empty()) {
      if (callback.one_at_a_time) of_thread[{callback.ros_node, callback.nodelet, 0}].push_back(vertex);
      continue;
    }
    const std::int64_t thread = callback.runs.front().thread;
    const bool one = std::all_of(callback.runs.begin(), callback.runs.end(),
                                 [&](const ObservedRun& run) { return run.thread == thread; });
    if (one) of_thread[{callback.ros_node, {}, thread}].push_back(vertex);
  }
  for (const auto& [thread, nodes] : of_thread) {
    if (nodes.size() > 1) spinners_.push_back(nodes);
  }
}

// --- Text ---

std::string AppWriter::path_text(const Indices& path, const char* between) const {
  std::string text;
  for (const std::size_t vertex : path) {
    if (!text.empty()) text += between;
    text += vertices_[vertex].name;
  }
  return text;
}

std::string AppWriter::node_text(std::size_t index) const {
  const Vertex& vertex = vertices_[index];
  if (vertex.external()) {
    const std::string clock = vertex.period ? ", period: " + duration_text(*vertex.period) : "";
    const std::string who = vertex.ros_nodes.empty() ? "" : " of " + joined(vertex.ros_nodes);
    return "  " + vertex.name + ": { external: true" + clock + " }   # " + vertex.topic + who + "\n";
  }
  const ObservedCallback& callback = *vertex.callback;
  const bool is_timer = callback.kind == Binding::Kind::kTimer;
  std::string text = "  " + vertex.name + ": { ";
  const bool sets_rate = !in_subchain_behind_head(index);
  if (vertex.takes_all) text += "input: queue, ";
  if (vertex.period && sets_rate) {
    text += "fallback_rate: " + rate_text(std::max(*vertex.period, vertex.min_period.value_or(nanoseconds{0}))) + ", ";
  }
  if (is_timer) text += "max_rate: " + rate_text(*vertex.period) + ", ";
  if (vertex.min_period && sets_rate) text += "max_rate: " + rate_text(*vertex.min_period) + ", ";
  text += "ros: { node: " + callback.ros_node + (callback.nodelet.empty() ? "" : ", nodelet: " + callback.nodelet) +
          (is_timer ? ", timer: " + exact_text(callback.period) : ", topic: " + callback.name) + " } }   # ";
  if (!callback.type.empty()) text += callback.type + ", ";
  text += std::to_string(callback.runs.size()) + (callback.runs.size() == 1 ? " run" : " runs");
  if (vertex.publishers.size() > 1) text += "; each message counts: " + joined(vertex.publishers) + " send them";
  return text + "\n";
}

std::string AppWriter::graph_text() const {
  std::string text = "nodes:\n";
  for (const std::size_t vertex : graph_.order()) text += node_text(vertex);
  if (!edges_.empty()) text += "edges:\n";
  for (const std::size_t from : graph_.order()) {
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

std::string AppWriter::exclusive_text() const {
  std::string text;
  if (!spinners_.empty()) text += "exclusive:   # callbacks of one spinner or nodelet: their runs never overlap\n";
  std::map<std::string, int> used;
  for (const Indices& nodes : spinners_) {
    const std::string name = last_part(program_of(*vertices_[nodes.front()].callback));
    const int before = used[name]++;
    text +=
        "  " + name + (before == 0 ? "" : "_" + std::to_string(before + 1)) + ": [" + path_text(nodes, ", ") + "]\n";
  }
  return text;
}

std::string AppWriter::objective_text() const {
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

std::string AppWriter::costs_text() const {
  std::string text = "# Written by catan ros bind: CPU time of a run, 95 % and half of the runs below it.\n";
  for (const std::size_t index : graph_.order()) {
    const Vertex& vertex = vertices_[index];
    if (vertex.external()) continue;
    text += vertex.name + ": { cost: " + duration_text(cost_of(vertex)) +
            ", typical: " + duration_text(cost_percentile(*vertex.callback, 0.5)) + " }\n";
  }
  return text;
}

InferredApp AppWriter::write(const std::string& name) const {
  InferredApp inferred;
  inferred.remarks = remarks_;
  inferred.nodes = static_cast<std::size_t>(
      std::count_if(vertices_.begin(), vertices_.end(), [](const Vertex& vertex) { return !vertex.external(); }));
  if (inferred.nodes == 0) return inferred;
  inferred.app = "# Written by catan ros bind, from what running programs did. Check it, set the weights, then plan.\n";
  for (const std::string& remark : remarks_) inferred.app += "# - " + remark + "\n";
  inferred.app += "catan: 1\napp: " + name + "\n" + graph_text() + exclusive_text() + objective_text();
  inferred.costs = costs_text();
  return inferred;
}

}  // namespace

InferredApp infer_app(const std::vector<ObservedCallback>& callbacks, const Connections& connections,
                      const std::string& name) {
  MergedCallbacks data = merge_repeated(of_data(callbacks));
  const InferredGraph graph(data.callbacks, connections);
  return AppWriter(graph, std::move(data.remarks)).write(name);
}

}  // namespace catan_ros
