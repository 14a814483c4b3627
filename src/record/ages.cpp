#include "record/ages.h"

#include <algorithm>

namespace ctn::record {

AgeTracker::AgeTracker(const graph::Graph& graph) : nodes_(graph.nodes().size()) {
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    Node& node = nodes_[index];
    node.predecessors = graph.nodes()[index].predecessors;
    node.taken.resize(node.predecessors.size());
    for (const NodeId predecessor : node.predecessors) node.source = node.source && graph.node(predecessor).external;
  }
}

// Any in the range may be the oldest: a node that reads an input only now and then goes back further when it does.
std::optional<TimePoint> AgeTracker::oldest_output(const Node& node, std::uint64_t first, std::uint64_t last) {
  const std::uint64_t forgotten = node.newest > kHorizon ? node.newest - kHorizon : 0;
  last = std::min(last, node.newest);
  if (first <= forgotten || first > last) return std::nullopt;
  std::optional<TimePoint> oldest;
  for (std::uint64_t ahead = 0; ahead <= last - first; ++ahead) {
    const std::size_t place = (first + ahead) % kHorizon;
    if (place >= node.outputs.size()) continue;
    const Output& output = node.outputs[place];
    if (output.number != first + ahead || !output.origin) continue;
    oldest = std::min(oldest.value_or(*output.origin), *output.origin);
  }
  return oldest;
}

std::optional<TimePoint> AgeTracker::origin(NodeId node, std::size_t input, std::uint64_t first,
                                            std::uint64_t last) const {
  const Node& consumer = nodes_[node.index()];
  const std::optional<TimePoint> oldest =
      oldest_output(nodes_[consumer.predecessors[input].index()], std::max<std::uint64_t>(first, 1), last);
  return oldest ? oldest : consumer.taken[input];
}

std::optional<TimePoint> AgeTracker::taken_by(const Run& run, std::size_t input, bool& consumed) const {
  const Node& node = nodes_[run.node.index()];
  const auto entry = std::find_if(run.consumed.begin(), run.consumed.end(),
                                  [&](const Consumed& each) { return each.predecessor == node.predecessors[input]; });
  consumed = entry != run.consumed.end() && entry->first != 0;
  return consumed ? origin(run.node, input, entry->first, entry->last) : node.taken[input];
}

void AgeTracker::set_ages(Run& run) const {
  run.ages.clear();
  if (run.node.index() >= nodes_.size()) return;
  for (std::size_t input = 0; input < nodes_[run.node.index()].predecessors.size(); ++input) {
    bool consumed = false;
    const std::optional<TimePoint> origin = taken_by(run, input, consumed);
    run.ages.push_back(origin ? std::max(run.begin - *origin, Nanos{0}) : kNoAge);
  }
}

TimePoint AgeTracker::add(Run& run) {
  set_ages(run);
  if (run.node.index() >= nodes_.size() || run.number == 0) return run.begin;
  Node& node = nodes_[run.node.index()];
  std::optional<TimePoint> oldest;
  for (std::size_t input = 0; input < node.predecessors.size(); ++input) {
    bool consumed = false;
    const std::optional<TimePoint> origin = taken_by(run, input, consumed);
    if (!origin) continue;
    node.taken[input] = origin;
    if (consumed) oldest = oldest ? std::min(*oldest, *origin) : *origin;
  }
  if (oldest) node.origin = oldest;
  const TimePoint origin = node.source ? run.begin : node.origin.value_or(run.begin);
  const std::size_t place = run.number % kHorizon;
  if (place >= node.outputs.size()) {
    node.outputs.resize(std::min(kHorizon, std::max(place + 1, 2 * node.outputs.size())));
  }
  node.newest = std::max(node.newest, run.number);
  node.outputs[place] = {run.number, run.emitted ? std::optional(origin) : std::nullopt};
  return origin;
}

}  // namespace ctn::record
