// The nodes that this process runs: their functions, their ports, the channels between them (connections.h). Made
// before they start.
//
// Thread safety: none until the session runs; from then on nothing here changes but the ports and what is wrong.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <typeindex>
#include <utility>
#include <vector>

#include "base/result.h"
#include "catan/channel.h"
#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/connections.h"
#include "runtime/node_port.h"

namespace ctn::runtime {

class Wiring {
 public:
  // All outlive it.
  Wiring(const graph::App& app, os::Os& os, const Region& region);
  Wiring(const Wiring&) = delete;
  Wiring& operator=(const Wiring&) = delete;

  // As Connections has them.
  void set_body(std::string_view node, NodeBody body) { connections_.set_body(node, std::move(body)); }
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make) {
    return connections_.open_channel(from, to, queue, type, make);
  }
  ChannelBase& unconnected_channel(MakeChannel make) { return connections_.unconnected_channel(make); }
  Status check(bool all) const { return connections_.check(all); }
  const NodeBody& body(NodeId node) const { return connections_.body(node); }
  std::vector<std::pair<std::string, std::uint64_t>> dropped() const { return connections_.dropped(); }
  // To those who call too late: the app has started.
  void close(Connections::OnLate on_late);
  // As the user is told of them (`channel-misuse`).
  std::vector<record::Notice> take_misuses(TimePoint now) const;

  NodePort* port(NodeId node) { return ports_[node.index()].get(); }  // null: external

 private:
  std::vector<std::unique_ptr<NodePort>> ports_;
  Connections connections_;
};

}  // namespace ctn::runtime
