// Which server's region (region.h) each node of this program uses. A new server has a new region, to which nodes move,
// each with its next run; the one before stays mapped until the last of them has left it. Servers may differ in whether
// subchains are cut (graph/cut.h).
//
// Units: none. Thread safety: one owner at a time, first the thread that connects, then the one that watches the
// server; nodes use the regions meanwhile, through their ports.
#pragma once

#include <list>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "base/result.h"
#include "graph/app.h"
#include "graph/cut.h"
#include "os/linux/shared_memory.h"
#include "runtime/region.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

class ServedRegions {
 public:
  // `app`, whose file is `text`, outlives it.
  ServedRegions(const graph::App& app, std::string text)
      : app_(app),
        cut_(std::make_unique<const graph::App>(graph::cut_at_fallback_rates(app))),
        text_(std::move(text)) {}

  // The newest from now on; no node uses it yet. kEnvironment: it is no region, or that of another app, or version.
  Status add(os::SharedMemory memory);
  // Takes back the newest add(). Precondition: there was one before, and no node has moved since.
  void drop_newest() { regions_.pop_back(); }
  const Region& newest() const { return regions_.back().region; }
  // The app, in the subchains that the newest server has; it lives as long as this, also where this is moved.
  const graph::App& newest_app() const { return *regions_.back().app; }
  // Whether the newest lies in this memory: its server was away, and is the same.
  bool is_newest(const os::SharedMemory& memory) const { return memory.is(regions_.back().memory); }

  // All nodes of this app move to the newest region: the nodes in `running`, which have a thread here, with their next
  // run, the others at once. A node takes a trigger that waits there already.
  void move_nodes(Wiring& wiring, std::span<const NodeId> running) const;
  // Lets go of the regions that no node uses any more.
  void drop_old(Wiring& wiring, std::span<const NodeId> running);
  std::size_t count() const { return regions_.size(); }

 private:
  struct Served {
    os::SharedMemory memory;
    Region region;
    const graph::App* app;
  };

  const graph::App& app_;
  std::unique_ptr<const graph::App> cut_;  // graph/cut.h
  std::string text_;
  std::list<Served> regions_;  // the newest last
};

}  // namespace ctn::runtime
