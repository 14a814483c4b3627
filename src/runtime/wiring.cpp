#include "runtime/wiring.h"

#include <utility>

namespace ctn::runtime {

Wiring::Wiring(const graph::App& app, os::Os& os, const Region& region)
    : connections_(app, [this](NodeId consumer, std::size_t input, ChannelBase& channel) {
        port(consumer)->set_channel(input, channel);
      }) {
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    const bool external = app.graph.nodes()[index].external;
    ports_.push_back(external ? nullptr : std::make_unique<NodePort>(os, app.graph, NodeId(index), region));
  }
}

void Wiring::close(Connections::OnLate on_late) {
  connections_.close("its nodes run already, so that nothing is changed", "call it before start()", std::move(on_late));
}

std::vector<record::Notice> Wiring::take_misuses(TimePoint now) const {
  std::vector<record::Notice> notices;
  for (std::string& misuse : connections_.take_misuses()) notices.push_back({now, "channel-misuse", std::move(misuse)});
  return notices;
}

}  // namespace ctn::runtime
