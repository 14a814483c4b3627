// The nodes of this program that are registered with a server, their threads, and what scheduling these had before any
// server touched them; gives that back when there is no server to do it.
//
// Units: in the types. Thread safety: every call from any thread; none but join() waits for anything but the others.
#pragma once

#include <string>
#include <vector>

#include "base/guarded.h"
#include "base/ids.h"
#include "base/result.h"
#include "os/os.h"
#include "runtime/region.h"
#include "runtime/saved_threads.h"
#include "runtime/server_link.h"

namespace ctn::runtime {

class ClientNodes {
 public:
  struct RegisteredNode {
    NodeId node;
    os::ThreadId thread;
    std::vector<os::ThreadId> others{};  // that the program has named as the node's, too
  };

  // `os` outlives it.
  explicit ClientNodes(os::Os& os) : os_(os), state_(os) {}

  // Remembers what the thread has, unless a server has raised it already.
  void add(NodeId node, os::ThreadId thread);
  // The newest of them that is this node with this thread, which gets back what it had.
  void remove(NodeId node, os::ThreadId thread);
  bool has(NodeId node) const;
  // The same of another thread. Nothing where the node is not there. One that ends is forgotten, by the next call that
  // adds, updates or restores at the latest, also where another has its number by then.
  void add_thread(NodeId node, os::ThreadId thread);
  void remove_thread(NodeId node, os::ThreadId thread);
  // One that works for all nodes of this program, which the server is yet to be told of. It is forgotten as those are.
  // Errors: a thread of another process.
  Status share(os::ThreadId thread);
  std::vector<os::ThreadId> shared() const { return state_.lock()->shared; }
  std::vector<RegisteredNode> all() const { return state_.lock()->nodes; }
  // Says to a server that this program runs the node, with all its threads; which are shared is said by
  // tell_all_shared().
  Status join(const RegisteredNode& registered, const std::string& name, Conversation& conversation,
              const Meanwhile& meanwhile);
  Status tell_all_shared(Conversation& conversation, const Meanwhile& meanwhile);
  // The same of those that were named since a server was last told.
  Status tell_shared(Conversation& conversation, const Meanwhile& meanwhile);
  bool has_untold() const { return !state_.lock()->untold.empty(); }
  // Before a server gets the threads again: what they have by now is what they get back, unless it is a server's doing.
  void update_saved_scheduling();

  // Restores the scheduling of threads that a server has raised or moved: the nodes' own, those that work for all, and
  // threads that it lists beside them in the region, whether they were named or it has found them by itself. The region
  // may hold anything, so only threads of this process are touched; threads of which this process does not know what
  // they had become ordinary, and get the CPUs of the node's own.
  void restore_threads(const Region& region);
  // Whether a server has raised one of them.
  bool any_raised(const Region& region) const;

 private:
  struct State {
    explicit State(os::ThreadScheduling& scheduling) : saved(scheduling) {}

    std::vector<RegisteredNode> nodes;
    std::vector<os::ThreadId> shared;
    std::vector<os::ThreadId> untold;  // of these
    SavedThreads saved;
  };

  void save(SavedThreads& saved, const os::SavedScheduling& now) const;
  void forget_ended(State& state) const;
  bool raised_by_server(os::ThreadId thread) const;
  static std::vector<os::ThreadId> threads_of(const RegisteredNode& registered, const Region& region,
                                              const std::vector<os::ThreadId>& living);

  os::Os& os_;
  Guarded<State> state_;
};

}  // namespace ctn::runtime
