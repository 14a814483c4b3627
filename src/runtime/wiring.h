// The app's nodes in this process: their ports, their functions, the channels between them. Made before the session
// starts; mistakes are gathered and told all at once.
//
// Thread safety: none until the session runs; from then on nothing here changes but the ports.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <typeindex>
#include <utility>
#include <vector>

#include "base/result.h"
#include "catan/channel.h"
#include "catan/run.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/node_port.h"

namespace ctn::runtime {

using NodeBody = std::function<void(Run&)>;
using MakeChannel = std::unique_ptr<ChannelBase> (*)(std::uint32_t slot);

class Wiring {
 public:
  // `app` and `os` outlive it.
  Wiring(const graph::App& app, os::Os& os);

  void set_body(std::string_view node, NodeBody body);
  // The same edge with the same type gives the same channel. A mistake is noted, and the channel returned leads
  // nowhere.
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make);

  // Everything that was wrong so far, nodes without a function included. kCaller.
  Status check() const;

  NodePort* port(NodeId node) { return ports_[node.index()].get(); }  // null: external
  const NodeBody& body(NodeId node) const { return bodies_[node.index()]; }
  SubchainSignal& signal(SubchainId subchain) { return *signals_[subchain.index()]; }
  std::vector<NodePort*> ports_of(SubchainId subchain);
  // By SubchainId.
  std::vector<SubchainPorts> subchains();
  // Values that queue channels lost, by edge name ("scan -> GL").
  std::vector<std::pair<std::string, std::uint64_t>> dropped() const;

 private:
  struct OpenChannel {
    std::type_index type;
    std::unique_ptr<ChannelBase> channel;
  };

  void complain(std::string what, std::string mend);
  ChannelBase& nowhere(MakeChannel make);

  const graph::App& app_;
  std::vector<std::unique_ptr<NodePort>> ports_;
  std::vector<std::unique_ptr<SubchainSignal>> signals_;
  std::vector<NodeBody> bodies_;
  std::map<std::pair<NodeId, NodeId>, OpenChannel> channels_;
  std::vector<std::unique_ptr<ChannelBase>> nowhere_;
  std::vector<Problem> problems_;
};

}  // namespace ctn::runtime
