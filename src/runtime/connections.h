// What a program has said about its nodes: their functions and the channels between them, checked against the app.
// Mistakes are collected and reported all at once. A session's wiring and a simulation share it.
//
// Thread safety: none until close(), before nodes run. From then on nothing here changes but what is wrong, and any
// thread may call all but close().
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <typeindex>
#include <utility>
#include <vector>

#include "base/guarded.h"
#include "base/result.h"
#include "catan/channel.h"
#include "catan/run.h"
#include "graph/app.h"

namespace ctn::runtime {

using NodeBody = std::function<void(Run&)>;

class Connections {
 public:
  // Hears of each new channel: into which input (by predecessor) of which node.
  using OnChannel = std::function<void(NodeId consumer, std::size_t input, ChannelBase& channel)>;

  // `app` outlives it.
  Connections(const graph::App& app, OnChannel on_channel);

  void set_body(std::string_view node, NodeBody body) { set(bodies_, "node", node, std::move(body)); }
  void set_effect(std::string_view node, NodeBody effect) { set(effects_, "on_effect", node, std::move(effect)); }
  // The same edge with the same type gives the same channel. A mistake is noted, and the channel returned leads
  // nowhere.
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make);
  // A channel that is not connected, returned after a mistake.
  ChannelBase& unconnected_channel(MakeChannel make);
  void add_problem(std::string what, std::string hint);

  // Everything that was wrong so far. `all`: nodes without a function are wrong too. kCaller.
  Status check(bool all) const;

  const NodeBody& body(NodeId node) const { return bodies_[node.index()]; }
  const NodeBody& effect(NodeId node) const { return effects_[node.index()]; }
  // Values that queue channels lost, by edge name ("scan -> GL").
  std::vector<std::pair<std::string, std::uint64_t>> dropped() const;
  using OnLate = std::function<void(const std::string& problem)>;
  // Nodes run from now on. Calls that would change something do nothing and are wrong, for the reason `why`, which
  // `on_late` is told once each.
  void close(std::string why, std::string hint, OnLate on_late = {});
  // Uses of channels by runs of other nodes than their two, each channel's first, in words; what was not told before.
  // None before close(). By one thread at a time, which may be another than the one that opens channels.
  std::vector<std::string> take_misuses() const;

 private:
  struct OpenChannel {
    std::type_index type;
    std::unique_ptr<ChannelBase> channel;
  };

  struct Late {
    std::string why;
    std::string hint;
    OnLate on_late;  // may be empty
  };

  // Whether the call comes too late. Then it is noted.
  bool is_late(const std::string& call);
  void set(std::vector<NodeBody>& functions, const char* call, std::string_view node, NodeBody function);

  const graph::App& app_;
  OnChannel on_channel_;
  std::vector<NodeBody> bodies_;
  std::vector<NodeBody> effects_;
  std::map<std::pair<NodeId, NodeId>, OpenChannel> channels_;
  Guarded<std::vector<std::unique_ptr<ChannelBase>>> unconnected_;
  Guarded<std::vector<Problem>> problems_;
  Late late_;  // from close() on
  std::atomic<bool> closed_{false};
};

}  // namespace ctn::runtime
