// Edges: paths to edges, cycles, the topological order, and what follows along edges.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <queue>

#include "base/text.h"
#include "graph/app_builder.h"

namespace ctn::graph {

void AppBuilder::add_edges() {
  for (std::size_t i = 0; i < spec_.edges.size(); ++i) add_path(i);
  for (const WrittenEdge& written : written_edges_) {
    app_.graph.edges_.push_back(written.edge);
    app_.graph.nodes_[written.edge.from.index()].successors.push_back(written.edge.to);
    app_.graph.nodes_[written.edge.to.index()].predecessors.push_back(written.edge.from);
  }
}

// Paths may share edges, as two chains with one beginning do; a path all of whose edges were written before, and that
// gives them no age limit, says nothing, and is more likely a slip than meant.
void AppBuilder::add_path(std::size_t index) {
  const PathSpec& path = spec_.edges[index];
  const std::string key = fmt::format("edges[{}]", index);
  if (path.nodes.size() < 2) {
    problem(path.place, key, "a path needs two nodes or more", "write it as in scan -> LM");
    for (const Name& name : path.nodes) {
      if (const auto known = node_index_.find(name.value); known != node_index_.end()) open_ends_.insert(known->second);
    }
    return;
  }
  const bool limits = check_age_limit(path, key);
  bool adds = path.max_age || path.on_stale;
  const WrittenEdge* earlier = nullptr;
  std::optional<NodeId> from;
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    const auto to = resolve_node(path.nodes[i], key);
    if (from && to && *from == *to) {
      problem(path.nodes[i].place, key, fmt::format("an edge leads from {} to itself", quote(path.nodes[i].value)),
              "remove it: a node that needs its own last output can keep it");
      adds = true;
    } else if (from && to) {
      const auto [place, fresh] = edge_index_.try_emplace({*from, *to}, written_edges_.size());
      if (fresh) {
        written_edges_.push_back({{*from, *to}, index, path.nodes[i].place});
      } else {
        earlier = &written_edges_[place->second];
      }
      adds = adds || fresh;
      if (limits) limit_age(written_edges_[place->second], index, key);
    } else if (i > 0) {
      adds = true;  // an unknown node was reported; what the path would have added is not known
      if (from || to) open_ends_.insert(from ? *from : *to);
    }
    from = to;
  }
  if (!adds && earlier != nullptr) {
    problem(
        path.place, key,
        fmt::format("this path adds no edge: all of them were written before, the last in edges[{}]", earlier->path),
        "remove it");
  }
}

// Whether the path gives its edges an age limit.
bool AppBuilder::check_age_limit(const PathSpec& path, const std::string& key) {
  if (path.max_age && path.max_age->value <= Nanos{0}) {
    problem(path.max_age->place, key + ".max_age", "max_age must be more than 0",
            "write how old data may be, as in 100ms");
    return false;
  }
  if (path.on_stale && !path.max_age) {
    problem(path.on_stale->place, key + ".on_stale",
            "on_stale says what becomes of data that is older than max_age, which is missing",
            "add max_age: 100ms, say, or remove on_stale");
  }
  return path.max_age.has_value();
}

void AppBuilder::limit_age(WrittenEdge& written, std::size_t path, const std::string& key) {
  const PathSpec& spec = spec_.edges[path];
  const std::string name = name_of(written.edge.from) + " -> " + name_of(written.edge.to);
  for (const NodeId end : {written.edge.from, written.edge.to}) {
    if (!app_.graph.node(end).external) continue;
    problem(
        spec.max_age->place, key + ".max_age",
        fmt::format("edge {} cannot have an age limit: {} is external, and it is not known when it gives or takes data",
                    name, quote(name_of(end))),
        "limit edges between nodes that are not external");
    return;
  }
  if (written.limited_by) {
    problem(spec.max_age->place, key + ".max_age",
            fmt::format("edge {} has an age limit already, by edges[{}]", name, *written.limited_by),
            "write one of them");
    return;
  }
  written.limited_by = path;
  written.edge.age_limit = AgeLimit{spec.max_age->value, spec.on_stale ? spec.on_stale->value : OnStale::kRun};
}

// Depth first, without recursion; an edge that leads back into the current trail closes a cycle.
void AppBuilder::check_cycles() {
  enum class Mark { kNew, kOnTrail, kDone };
  const std::size_t count = app_.graph.nodes_.size();
  std::vector<Mark> marks(count, Mark::kNew);
  std::vector<std::size_t> next(count, 0);
  for (std::size_t root = 0; root < count; ++root) {
    if (marks[root] != Mark::kNew) continue;
    std::vector<NodeId> trail{NodeId(root)};
    marks[root] = Mark::kOnTrail;
    while (!trail.empty()) {
      const NodeId from = trail.back();
      const auto& successors = app_.graph.node(from).successors;
      if (next[from.index()] == successors.size()) {
        marks[from.index()] = Mark::kDone;
        trail.pop_back();
        continue;
      }
      const NodeId to = successors[next[from.index()]++];
      if (marks[to.index()] == Mark::kOnTrail) {
        report_cycle(trail, written_edges_[edge_index_.at({from, to})]);
      } else if (marks[to.index()] == Mark::kNew) {
        marks[to.index()] = Mark::kOnTrail;
        trail.push_back(to);
      }
    }
  }
}

void AppBuilder::report_cycle(const std::vector<NodeId>& trail, const WrittenEdge& closing) {
  constexpr std::ptrdiff_t kMaxNamed = 10;
  auto step = std::find(trail.rbegin(), trail.rend(), closing.edge.to).base() - 1;
  std::string cycle;
  for (std::ptrdiff_t named = 0; step != trail.end() && named < kMaxNamed; ++step, ++named) {
    cycle += name_of(*step) + " -> ";
  }
  if (step != trail.end()) cycle += "... -> ";
  problem(closing.place, fmt::format("edges[{}]", closing.path),
          fmt::format("the edges form a cycle: {}{}", cycle, name_of(closing.edge.to)),
          "remove one of its edges: information flows one way, from sources to sinks");
}

// Precondition: no cycle.
void AppBuilder::sort_topologically() {
  std::vector<std::size_t> missing;
  std::priority_queue<NodeId, std::vector<NodeId>, std::greater<>> ready;
  for (const Node& node : app_.graph.nodes_) {
    if (node.predecessors.empty()) ready.push(NodeId(missing.size()));
    missing.push_back(node.predecessors.size());
  }
  while (!ready.empty()) {
    const NodeId id = ready.top();
    ready.pop();
    app_.graph.topological_.push_back(id);
    for (const NodeId successor : app_.graph.node(id).successors) {
      if (--missing[successor.index()] == 0) ready.push(successor);
    }
  }
}

// An unscheduled node without a period follows the fastest of the unscheduled nodes that feed it, where speed is how
// often they can give output; of equals the first.
void AppBuilder::complete_periods() {
  auto& nodes = app_.graph.nodes_;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].unscheduled || nodes[i].period) continue;
    const auto& before = nodes[i].predecessors;
    if (std::any_of(before.begin(), before.end(), [&](NodeId id) { return nodes[id.index()].unscheduled; })) continue;
    problem(node_specs_[i]->name.place, fmt::format("nodes.{}.period", nodes[i].name),
            "an unscheduled node that no other unscheduled node feeds needs a period",
            "add period: 5ms, say: how often it runs");
  }
  for (const NodeId id : app_.graph.topological_) {
    Node& node = nodes[id.index()];
    if (!node.unscheduled || node.period) continue;
    for (const NodeId before : node.predecessors) {
      const Node& predecessor = nodes[before.index()];
      if (!predecessor.unscheduled || !predecessor.period) continue;
      const Nanos every = predecessor.outputs_apart();
      if (node.period && *node.period <= every) continue;
      node.period = every;
      node.follows = before;
    }
  }
}

}  // namespace ctn::graph
