// Which program runs which node: what a server (server.h) does with what programs say (protocol.h). It knows of no
// socket, so the tests and the fuzzer speak to it directly.
//
// What it sees to:
//   - only a program that may control the server changes anything but its own nodes, or is told of others,
//   - else only a program that has said hello is listened to; it may only name threads that are its own, and only nodes
//     that it runs,
//   - a node is run by one program at a time, so that programs run no more nodes than the app has (of programs, the
//     server turns away those that are too many),
//   - a message that another process wrote on a program's connection (a child that it forked, say) is refused,
//   - when a program has ended, all its nodes leave,
//   - all threads of a program that runs one node are the node's, also those that it makes later, except the one that
//     serves the connection. Where a program runs several nodes, other threads say which one they belong to ("add"),
//     and the threads that were found while it ran one are given up. A program's threads are not searched before no
//     node has joined between two searches, so that threads of nodes that join one after the other are not taken for
//     the first one's,
//   - a thread that works for all nodes of a program (its middleware's, "add" without a node) is one of the node's that
//     weighs most of those that the program runs, by the weights of the app file; of another's, when that leaves or one
//     joins that weighs more. It is no other node's, and with the last node it gets back what it had.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "os/threads.h"
#include "runtime/ordinary_threads.h"
#include "runtime/protocol.h"
#include "runtime/scheduler.h"

namespace ctn::runtime {

class Registry {
 public:
  using ProgramId = std::uint64_t;

  // Both outlive it.
  Registry(os::Threads& threads, Scheduler& scheduler) : threads_(threads), scheduler_(scheduler) {}

  // A program has connected. `may_control`: it may change what is scheduled, and how, of the whole app.
  ProgramId enter(os::ProcessId process, bool may_control = false);
  // Memory whose descriptor goes with an answer.
  enum class Attached { kNone, kRegion, kStatus, kFlight };
  struct Answer {
    std::string text;
    Attached attached = Attached::kNone;
  };
  // What to answer. `sender`: the process that wrote the message.
  Answer handle(ProgramId program, os::ProcessId sender, std::string_view message);
  // It has ended, or is turned away: `why` is for the notice.
  void leave(ProgramId program, const std::string& why);

  // Finds threads that programs have made or ended since it was last called: ten times a second is often enough.
  void find_threads();
  // Gives a notice (`ordinary-threads`) of programs whose threads that no node has wait for a CPU most of the time, as
  // ordinary_threads.h tells. To be called once in OrdinaryThreads::kPeriod. Does nothing where nodes do not go before
  // such threads.
  void look_at_ordinary_threads(TimePoint now);

 private:
  using Threads = std::vector<os::ThreadId>;
  struct Program {
    os::ProcessId process{};
    bool may_control = false;
    std::optional<os::ThreadId> service;  // once it has said hello
    std::set<NodeId> nodes;
    Threads found;                 // found by find_threads(), not named by the program
    Threads shared;                // that work for all nodes
    std::optional<NodeId> sharer;  // whose threads these are at the moment
    bool joined_since_search = false;
    OrdinaryThreads ordinary;
  };

  Status carry_out(Program& program, const Request& request);
  Status control(const Program& program, const Request& request);
  Status hello(Program& program, const Request& request);
  Result<NodeId> own_node(const Program& program, const std::string& name) const;
  Result<Threads> threads_with(const Program& program, os::ThreadId thread) const;
  void find_threads(Program& program);
  void give_up_found(os::ProcessId process);
  std::size_t nodes_of(os::ProcessId process) const;
  std::set<os::ThreadId> services() const;
  Status share(Program& program, os::ThreadId thread);
  void unshare(Program& program, os::ThreadId thread);
  void hand_over_shared(Program& program);
  void place_shared(Program& program);
  void place_shared(Program& program, const Threads& living);
  std::set<os::ThreadId> threads_of_nodes() const;
  std::vector<OrdinaryThreads::Sample> sample(const Program& program, const std::set<os::ThreadId>& left_out) const;
  std::string describe(const Program& program) const;
  std::optional<NodeId> heaviest(const Program& program) const;

  os::Threads& threads_;
  Scheduler& scheduler_;
  std::map<ProgramId, Program> programs_;
  ProgramId next_ = 0;
};

}  // namespace ctn::runtime
