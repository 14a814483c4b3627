// Unscheduled nodes have no controller that would see that a run hangs, and are above all that are scheduled. Here the
// CPU time of their threads is watched: where it is a second since the node's last run began, they are lowered to the
// ordinary level until the next run begins. A run that waits for a device uses none, however long it takes.
//
// The housekeeping thread looks, at the ordinary level: on a machine whose every CPU is taken by such a run it has what
// the kernel keeps for ordinary threads, 5 % unless that is switched off.
//
// Units: Nanos of CPU time. Thread safety: none; the housekeeping thread's.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "graph/app.h"
#include "runtime/node_link.h"
#include "runtime/region.h"
#include "runtime/registered_nodes.h"

namespace ctn::runtime {

class UnscheduledWatch {
 public:
  static constexpr Nanos kMaxCpuTime = std::chrono::seconds{1};

  // References outlive it.
  UnscheduledWatch(const graph::Graph& graph, const Region& region, const Links& links, RegisteredNodes& registered);

  // `notice` is called with what is to be told.
  void look(const std::function<void(const std::string&)>& notice);

 private:
  struct Watched {
    NodeId node;
    std::uint64_t number = 0;  // of the newest run
    Nanos used_before{0};      // when that was seen first
    bool lowered = false;
  };
  Nanos cpu_time_of(NodeId node) const;

  const graph::Graph& graph_;
  const Region& region_;
  const Links& links_;
  RegisteredNodes& registered_;
  std::vector<Watched> watched_;
};

}  // namespace ctn::runtime
