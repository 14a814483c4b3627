#include "runtime/wiring.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace ctn::runtime {

Wiring::Wiring(const graph::App& app, os::Os& os) : app_(app), bodies_(app.graph.nodes().size()) {
  const graph::Graph& graph = app.graph;
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const bool external = graph.nodes()[index].external;
    ports_.push_back(external ? nullptr : std::make_unique<NodePort>(os, graph, NodeId(index)));
  }
  for (std::size_t index = 0; index < ports_.size(); ++index) {
    if (!ports_[index]) continue;
    const std::vector<NodeId>& predecessors = graph.nodes()[index].predecessors;
    for (std::size_t slot = 0; slot < predecessors.size(); ++slot) {
      ports_[index]->connect_input(slot, port(predecessors[slot]));
    }
  }
  for (const graph::Subchain& subchain : graph.subchains()) {
    signals_.push_back(std::make_unique<SubchainSignal>());
    for (std::size_t index = 0; index < subchain.nodes.size(); ++index) {
      NodePort* next = index + 1 < subchain.nodes.size() ? port(subchain.nodes[index + 1]) : nullptr;
      port(subchain.nodes[index])->connect_subchain(next, signals_.back().get());
    }
  }
}

void Wiring::complain(std::string what, std::string mend) {
  problems_.push_back({{}, {}, std::move(what), std::move(mend)});
}

void Wiring::set_body(std::string_view node, NodeBody body) {
  const std::optional<NodeId> id = app_.graph.find_node(node);
  if (!id) {
    complain(fmt::format("node(\"{}\"): app {} has no such node", node, app_.name),
             "use a name from its nodes section");
  } else if (app_.graph.node(*id).external) {
    complain(fmt::format("node(\"{}\"): the node is external", node),
             "give no function to it, or drop 'external: true'");
  } else if (bodies_[id->index()]) {
    complain(fmt::format("node(\"{}\"): the node has a function already", node), "call node() once for each");
  } else if (!body) {
    complain(fmt::format("node(\"{}\"): the function is empty", node), "pass one that can be called");
  } else {
    bodies_[id->index()] = std::move(body);
  }
}

ChannelBase& Wiring::nowhere(MakeChannel make) { return *nowhere_.emplace_back(make(0)); }

ChannelBase& Wiring::open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                                  MakeChannel make) {
  const std::string call = fmt::format("{}(\"{}\", \"{}\")", queue ? "queue" : "channel", from, to);
  const std::optional<NodeId> producer = app_.graph.find_node(from);
  const std::optional<NodeId> consumer = app_.graph.find_node(to);
  if (!producer || !consumer || !app_.graph.has_edge(*producer, *consumer)) {
    complain(fmt::format("{}: app {} has no such edge", call, app_.name),
             fmt::format("write it under edges: {} -> {}", from, to));
    return nowhere(make);
  }
  const graph::Node& reader = app_.graph.node(*consumer);
  if (reader.external || app_.graph.node(*producer).external) {
    complain(call + ": one end is external", "channels join nodes of this process");
    return nowhere(make);
  }
  if (queue != (reader.input == graph::InputKind::kQueue)) {
    complain(fmt::format("{}: the input of {} is {}", call, to, queue ? "latest" : "a queue"),
             queue ? "use channel(), or write input: queue" : "use queue(), or drop input: queue");
    return nowhere(make);
  }
  const auto known = channels_.find({*producer, *consumer});
  if (known != channels_.end()) {
    if (known->second.type == type) return *known->second.channel;
    complain(call + ": opened before with another type", "use one type for an edge");
    return nowhere(make);
  }
  const auto slot = static_cast<std::size_t>(
      std::find(reader.predecessors.begin(), reader.predecessors.end(), *producer) - reader.predecessors.begin());
  port(*consumer)->set_channel(slot);
  OpenChannel opened{type, make(static_cast<std::uint32_t>(slot))};
  return *channels_.emplace(std::pair{*producer, *consumer}, std::move(opened)).first->second.channel;
}

Status Wiring::check() const {
  std::vector<Problem> problems = problems_;
  for (std::size_t index = 0; index < bodies_.size(); ++index) {
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

std::vector<NodePort*> Wiring::ports_of(SubchainId subchain) {
  std::vector<NodePort*> ports;
  for (const NodeId node : app_.graph.subchain(subchain).nodes) ports.push_back(port(node));
  return ports;
}

std::vector<SubchainPorts> Wiring::subchains() {
  std::vector<SubchainPorts> all;
  for (std::size_t index = 0; index < signals_.size(); ++index) {
    all.push_back({ports_of(SubchainId(index)), signals_[index].get()});
  }
  return all;
}

std::vector<std::pair<std::string, std::uint64_t>> Wiring::dropped() const {
  std::vector<std::pair<std::string, std::uint64_t>> dropped;
  for (const auto& [edge, open] : channels_) {
    if (open.channel->dropped() == 0) continue;
    const NodeId path[] = {edge.first, edge.second};
    dropped.emplace_back(app_.graph.path_name(path), open.channel->dropped());
  }
  return dropped;
}

}  // namespace ctn::runtime
