// The nodes of this program that are registered with a server, their threads, and what scheduling these had before any
// server touched them; gives that back when there is no server to do it.
//
// Units: in the types. Thread safety: every call from any thread; none but join() waits for anything but the others.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/guarded.h"
#include "base/ids.h"
#include "base/result.h"
#include "os/os.h"
#include "runtime/region.h"
#include "runtime/server_link.h"

namespace ctn::runtime {

class ClientMembers {
 public:
  struct RegisteredNode {
    NodeId node;
    os::ThreadId thread;
    std::vector<os::ThreadId> others;  // that the program has named as the node's, too
    // The thread's when it registered. None: a server had raised it by then.
    std::optional<os::SavedScheduling> before;
  };

  // `os` outlives it.
  explicit ClientMembers(os::Os& os) : os_(os) {}

  // Remembers what the thread has, unless a server has raised it already.
  void add(NodeId node, os::ThreadId thread);
  // The newest of them that is this node with this thread.
  void remove(NodeId node, os::ThreadId thread);
  bool has(NodeId node) const;
  // Nothing where the node is not there.
  void add_thread(NodeId node, os::ThreadId thread);
  void remove_thread(NodeId node, os::ThreadId thread);
  std::vector<RegisteredNode> all() const { return *members_.lock(); }
  // Says to a server that this program runs the node, with all its threads. Those that have ended by now are forgotten.
  Status join(const RegisteredNode& registered, const std::string& name, Conversation& conversation,
              const Meanwhile& meanwhile);
  // Before a server gets the threads again: what they have by now is what they get back, unless it is a server's doing.
  void update_saved_scheduling();

  // Restores the scheduling of threads that a server has raised or moved: the members', and those that it lists beside
  // them in the region, which it has found by itself. The region may hold anything, so only threads of this process are
  // touched; those of whom nobody here knows what they had become ordinary, and else stay as the server's guardian left
  // them.
  void restore_threads(const Region& region) const;
  // Whether a server has raised one of them.
  bool any_raised(const Region& region) const;

 private:
  std::optional<os::SavedScheduling> scheduling_before(os::ThreadId thread) const;
  bool raised_by_server(os::ThreadId thread) const;
  void restore_threads(const RegisteredNode& member, const std::vector<os::ThreadId>& living,
                       const Region& region) const;

  os::Os& os_;
  Guarded<std::vector<RegisteredNode>> members_;
};

}  // namespace ctn::runtime
