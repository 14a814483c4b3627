#include "runtime/connections.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/run_access.h"

namespace ctn::runtime {

Connections::Connections(const graph::App& app, OnChannel on_channel)
    : app_(app),
      on_channel_(std::move(on_channel)),
      bodies_(app.graph.nodes().size()),
      effects_(app.graph.nodes().size()) {}

void Connections::add_problem(std::string what, std::string hint) {
  problems_.lock()->push_back({{}, {}, std::move(what), std::move(hint)});
}

void Connections::close(std::string why, std::string hint, OnLate on_late) {
  late_ = {std::move(why), std::move(hint), std::move(on_late)};
  closed_.store(true, std::memory_order_release);
}

bool Connections::is_late(const std::string& call) {
  if (!closed_.load(std::memory_order_acquire)) return false;
  const std::string what = call + ": " + late_.why;
  {
    const auto problems = problems_.lock();
    const auto is_known = [&](const Problem& problem) { return problem.what == what; };
    if (std::any_of(problems->begin(), problems->end(), is_known)) return true;
    problems->push_back({{}, {}, what, late_.hint});
  }
  if (late_.on_late) late_.on_late(what + "; " + late_.hint);
  return true;
}

void Connections::set(std::vector<NodeBody>& functions, const char* call, std::string_view node, NodeBody function) {
  const std::string called = fmt::format("{}(\"{}\")", call, node);
  if (is_late(called)) return;
  const std::optional<NodeId> id = app_.graph.find_node(node);
  if (!id) {
    add_problem(fmt::format("{}: app {} has no such node", called, app_.name), "use a name from its nodes section");
  } else if (app_.graph.node(*id).external) {
    add_problem(called + ": the node is external", "give no function to it, or drop 'external: true'");
  } else if (functions[id->index()]) {
    add_problem(called + ": the node has a function already", fmt::format("call {}() once for each", call));
  } else if (!function) {
    add_problem(called + ": the function is empty", "pass one that can be called");
  } else {
    functions[id->index()] = std::move(function);
  }
}

ChannelBase& Connections::unconnected_channel(MakeChannel make) {
  ChannelBase& channel = *unconnected_.lock()->emplace_back(make(0));
  RunAccess::leave_unconnected(channel);
  return channel;
}

ChannelBase& Connections::open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                                       MakeChannel make) {
  const std::string call = fmt::format("{}(\"{}\", \"{}\")", queue ? "queue" : "channel", from, to);
  const std::optional<NodeId> producer = app_.graph.find_node(from);
  const std::optional<NodeId> consumer = app_.graph.find_node(to);
  const auto known = producer && consumer ? channels_.find({*producer, *consumer}) : channels_.end();
  if (known != channels_.end() && known->second.type == type) return *known->second.channel;
  if (is_late(call)) return unconnected_channel(make);
  if (!producer || !consumer || !app_.graph.has_edge(*producer, *consumer)) {
    add_problem(fmt::format("{}: app {} has no such edge", call, app_.name),
                fmt::format("write it under edges: {} -> {}", from, to));
    return unconnected_channel(make);
  }
  const graph::Node& reader = app_.graph.node(*consumer);
  if (reader.external || app_.graph.node(*producer).external) {
    add_problem(call + ": one end is external", "channels join nodes of this process");
    return unconnected_channel(make);
  }
  if (queue != (reader.input == graph::InputKind::kQueue)) {
    add_problem(fmt::format("{}: the input of {} is {}", call, to, queue ? "latest" : "a queue"),
                queue ? "use channel(), or write input: queue" : "use queue(), or drop input: queue");
    return unconnected_channel(make);
  }
  if (known != channels_.end()) {
    add_problem(call + ": opened before with another type", "use one type for an edge");
    return unconnected_channel(make);
  }
  const auto input = static_cast<std::size_t>(
      std::find(reader.predecessors.begin(), reader.predecessors.end(), *producer) - reader.predecessors.begin());
  OpenChannel opened{type, make(static_cast<std::uint32_t>(input))};
  RunAccess::connect(*opened.channel, *producer, *consumer);
  on_channel_(*consumer, input, *opened.channel);
  return *channels_.emplace(std::pair{*producer, *consumer}, std::move(opened)).first->second.channel;
}

Status Connections::check(bool all) const {
  std::vector<Problem> problems = *problems_.lock();
  for (std::size_t index = 0; all && index < bodies_.size(); ++index) {
    const graph::Node& node = app_.graph.nodes()[index];
    if (node.external || bodies_[index]) continue;
    problems.push_back({{},
                        {},
                        fmt::format("node {} has no function", node.name),
                        fmt::format("call node(\"{}\", ...) before start(), or mark it external", node.name)});
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return Done{};
}

std::vector<std::pair<std::string, std::uint64_t>> Connections::dropped() const {
  std::vector<std::pair<std::string, std::uint64_t>> dropped;
  for (const auto& [edge, open] : channels_) {
    if (open.channel->dropped() == 0) continue;
    const NodeId path[] = {edge.first, edge.second};
    dropped.emplace_back(app_.graph.path_name(path), open.channel->dropped());
  }
  return dropped;
}

std::vector<std::string> Connections::take_misuses() const {
  std::vector<std::string> misuses;
  if (!closed_.load(std::memory_order_acquire)) return misuses;
  for (const auto& [edge, open] : channels_) {
    const std::optional<RunAccess::Misuse> misuse = RunAccess::take_misuse(*open.channel);
    if (!misuse) continue;
    const NodeId path[] = {edge.first, edge.second};
    const std::string who = misuse->node ? "node " + app_.graph.node(*misuse->node).name : "a run of no node";
    misuses.push_back(
        misuse->writes ? fmt::format("{} writes to channel {}, which is not its own, and nothing is written; only {} "
                                     "may write there",
                                     who, app_.graph.path_name(path), app_.graph.node(edge.first).name)
                       : fmt::format("{} reads from channel {}, which is not its own, and gets nothing; only {} may "
                                     "read there",
                                     who, app_.graph.path_name(path), app_.graph.node(edge.second).name));
  }
  return misuses;
}

}  // namespace ctn::runtime
