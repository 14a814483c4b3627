// Which nodes are registered. A node joins with its first thread, and may leave again, at any time. A subchain that
// misses one of its nodes is not triggered, and no other waits for it; it keeps its place in the plan, so that the
// rates of the others stay what they are. The housekeeping thread learns of changes by settle() and take_joined().
//
// Thread safety: all calls from any thread that is not a node's or a controller's; its lock guards what must change
// together, and is not held while threads are placed or restored.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "base/result.h"
#include "driver/notices.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/enforcer.h"
#include "runtime/node_link.h"
#include "runtime/region.h"

namespace ctn::runtime {

class RegisteredNodes {
 public:
  // How threads of nodes are placed when they join.
  struct Placement {
    os::CpuSet cpus;
    os::Level scheduled = os::Level::kOrdinary;  // to be had by their controllers, who set it
    os::Level unscheduled = os::Level::kOrdinary;
  };

  // References outlive it. Until open(), threads may be named for nodes, but no node can join.
  RegisteredNodes(const graph::App& app, os::Os& os, const Region& region, Links& links, driver::Notices& notices);
  // `enforcer` outlives its use: until expect_all_to_leave(), and all threads have been restored.
  void open(Enforcer& enforcer, Placement placement);

  // From now on unscheduled nodes are at this level at least, also nodes that have joined before. Precondition: open()
  // was called.
  void raise_unscheduled(os::Level level);
  // From now on threads are placed on these CPUs when they join. Threads that have joined stay where they are.
  void place_on(const os::CpuSet& cpus);

  // `thread` of `process` is the node's own. Errors: an external node, one that is there already (until leave() has
  // returned), a thread that works for another node, threads or CPUs that cannot be had.
  Status join(NodeId node, os::ProcessId process, os::ThreadId thread);
  // Another thread that works for the node. Errors: no room, a thread that works for another node.
  Status add_thread(NodeId node, os::ProcessId process, os::ThreadId thread);
  // A thread that has ended, or works for the node no more; its scheduling is restored.
  void remove_thread(NodeId node, os::ThreadId thread);
  // With all its threads. `why`: for the notice. False: it was not there.
  bool leave(NodeId node, const std::string& why);
  // The session ends: no notice is given of nodes that leave from now on.
  void expect_all_to_leave();

  // --- the housekeeping thread's ---
  // All nodes of the subchain are registered.
  bool has_all_of(const graph::Subchain& subchain) const;
  // Those that are not, in the order they run.
  std::vector<NodeId> missing_of(const graph::Subchain& subchain) const;
  struct Change {
    std::vector<SubchainId> left;  // of the subchains that were paced: a node was missing, if only for a while
    std::vector<SubchainId> back;  // of the others: all nodes are registered
  };
  // Since it was last called. `paced`: by subchain.
  Change settle(const std::vector<bool>& paced);
  // Nodes that joined since it was last called.
  std::vector<NodeId> take_joined();
  // Threads that have ended are removed: others may get their numbers.
  void forget_ended_threads();
  // All threads of an unscheduled node: to the ordinary level, and back to that of unscheduled nodes.
  void lower(NodeId node);
  void raise_again(NodeId node);

 private:
  // A node that joins or leaves is not registered, but there, so that no other program joins as it.
  enum class Presence : std::uint8_t { kAway, kJoining, kRegistered, kLeaving };
  void set(NodeId node, Presence presence);
  bool has_all(const graph::Subchain& subchain) const;  // under the lock
  std::vector<os::ThreadId> join_with(NodeId node, const std::vector<os::ThreadId>& placed);
  enum class Added { kNotPlaced, kNoRoom, kForLater, kToJoined };
  Added add_if_placed(NodeId node, os::ThreadId thread, bool placed);
  Status check_free(NodeId node, os::ThreadId thread) const;
  Status place(NodeId node, os::ProcessId process, os::ThreadId thread);
  os::Level level_of(NodeId node) const;
  void raise_if_changed(NodeId node, os::Level placed_at);
  void wake_holder(NodeId node);
  std::string broken_chains(NodeId node) const;

  const graph::App& app_;
  os::Os& os_;
  const Region& region_;
  Links& links_;
  driver::Notices& notices_;
  // Set before the first node joins. A thread that reads them has seen under the lock that one has.
  Enforcer* enforcer_ = nullptr;
  Placement placement_;
  std::atomic<os::Level> unscheduled_level_{os::Level::kOrdinary};  // changed under the lock

  mutable std::mutex mutex_;        // guards what follows
  std::vector<Presence> presence_;  // by node
  std::vector<bool> left_;          // by subchain: a node of it has left since it was last settled
  os::CpuSet cpus_;                 // where threads are placed
  std::vector<NodeId> joined_;      // since they were last taken
  bool leaving_is_expected_ = false;
};

}  // namespace ctn::runtime
