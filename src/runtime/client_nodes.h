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
  // The thread gets back what it had. Where the node was added several times with it, the newest of these goes.
  void remove(NodeId node, os::ThreadId thread);
  bool has(NodeId node) const;
  // As add() and remove(), for another thread of the node; nothing happens where the node is not there. A thread that
  // has ended is forgotten by the next call that adds, updates or restores, at the latest. A new thread that has its
  // number by then is not taken for it.
  void add_thread(NodeId node, os::ThreadId thread);
  void remove_thread(NodeId node, os::ThreadId thread);
  // A thread that works for all nodes of this program. The server learns of it by tell_shared(). It is forgotten as
  // those of nodes are. Errors: it is a thread of another process.
  Status share(os::ThreadId thread);
  std::vector<os::ThreadId> shared() const { return state_.lock()->shared; }
  std::vector<RegisteredNode> all() const { return state_.lock()->nodes; }
  // Tells a server that this program runs the node, and all of its threads but the shared ones: tell_all_shared().
  Status join(const RegisteredNode& registered, const std::string& name, Conversation& conversation,
              const Meanwhile& meanwhile);
  Status tell_all_shared(Conversation& conversation, const Meanwhile& meanwhile);
  // Only of those that no server has been told of yet.
  Status tell_shared(Conversation& conversation, const Meanwhile& meanwhile);
  bool has_untold() const { return !state_.lock()->untold.empty(); }
  // To be called before a server gets the threads again: what they have now is what they get back in the end, unless a
  // server gave it to them.
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
