#include "runtime/served_regions.h"

#include <fmt/format.h>

#include <algorithm>

namespace ctn::runtime {

Status ServedRegions::add(os::SharedMemory memory) {
  const Result<std::string> text = Region::text(memory.bytes());
  if (!text) return text.error();
  if (*text != text_) {
    return Error::environment(fmt::format("the server schedules app of another file, not {}", app_.name),
                              "connect to the server of the app, or start one");
  }
  const Result<bool> cut = Region::is_cut(memory.bytes());
  if (!cut) return cut.error();
  const graph::App& app = *cut ? *cut_ : app_;
  Result<Region> region = Region::open(app.graph, memory.bytes());
  if (!region) return region.error();
  regions_.push_back({std::move(memory), std::move(*region), &app});
  return Done{};
}

void ServedRegions::move_nodes(Wiring& wiring, std::span<const NodeId> running) const {
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    NodePort* const port = wiring.port(NodeId(index));
    if (port == nullptr || port->uses(newest())) continue;
    const bool runs = std::find(running.begin(), running.end(), NodeId(index)) != running.end();
    runs ? port->move_to(newest(), newest_app().graph) : port->bind_to(newest(), newest_app().graph);
  }
}

// A node is in the one before until its next run.
void ServedRegions::drop_old(Wiring& wiring, std::span<const NodeId> running) {
  if (regions_.size() == 1) return;
  for (const NodeId node : running) wiring.port(node)->wake_if_moved();
  regions_.remove_if([&](const Served& old) {
    return &old != &regions_.back() && std::none_of(running.begin(), running.end(),
                                                    [&](NodeId node) { return wiring.port(node)->uses(old.region); });
  });
}

}  // namespace ctn::runtime
