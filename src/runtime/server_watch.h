// Watches the server of a program's nodes, and moves the nodes to the next server when it is gone:
//   served   a server schedules the nodes. Its heartbeat is looked at (heartbeat_watch.h)
//   silent   there is a connection, but the heartbeat has ceased, as that of a server which is stopped: it counts as
//            gone until it goes on
//   away     there is no connection; another is tried now and then (redial.h)
//
// While none schedules them, it runs the subchains whose heads are this program's at their own rates
// (unserved_pacer.h), and restores the scheduling of threads (client_nodes.h). The program does so although the
// server's guardian does the same: the guardian may have been killed with the server, and it does nothing while the
// server is only stopped. A stopped server may have been in a call that raises a thread, which takes effect later; so
// for some seconds it is checked again whether a thread is raised.
//
// When a server is back, all nodes register again, all or none, and move to its region (served_regions.h).
//
// Units: Nanos. Thread safety: none; the thread that watches has it alone (owning_thread.h). What other threads are to
// know is in what it is given.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "driver/notices.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/client_nodes.h"
#include "runtime/heartbeat_watch.h"
#include "runtime/redial.h"
#include "runtime/served_regions.h"
#include "runtime/server_link.h"
#include "runtime/unserved_pacer.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

class ServerWatch {
 public:
  // How often, and for how long after a server went away, we look whether it raised a thread all the same: as long as
  // its guardian waits for it.
  static constexpr Nanos kRaisedSearchPeriod = std::chrono::milliseconds{20};
  static constexpr Nanos kLongestCall = std::chrono::seconds{10};

  // All outlive it.
  struct Program {
    os::Os& os;
    const graph::App& app;
    ServerLink& link;
    Wiring& wiring;
    ClientNodes& registered;
    driver::Notices& notices;
    std::atomic<bool>& served;  // written here
    std::function<bool()> stopping;
  };

  // The link is connected to the server whose region is the newest of `regions`. They outlive the nodes.
  ServerWatch(Program program, ServedRegions regions);

  // Turns until the program stops.
  void run();
  // What is due now. `gone`: the server has ended, has closed the connection, or did not answer. Returns when it is to
  // be called again.
  TimePoint step(TimePoint now, bool gone);
  // The nodes are no server's from now on, have the scheduling that they had before, and are told to stop.
  void leave();

 private:
  enum class State { kServed, kSilent, kAway };

  void set(State state);
  void tell_shared();
  void tell_misuses();
  bool server_alive(TimePoint now);
  void begin_heartbeat();
  void lose_server(TimePoint now, bool gone);
  void begin_pacing(TimePoint now);
  void restore_threads(TimePoint now);
  TimePoint run_without_server(TimePoint now);
  TimePoint pace_and_restore(TimePoint now);
  struct Dialled {
    Status done;
    bool answered = false;         // a server was there
    bool known = false;            // it is the one of before
    bool may_have_raised = false;  // some nodes may have joined before it refused others
  };
  void reconnect();
  Dialled dial_and_join();
  Status take_over(Conversation& conversation, os::SharedMemory memory, bool known);
  Status rejoin(Conversation& conversation);
  std::vector<NodeId> running() const;
  void notice(const std::string& text) { program_.notices.add({program_.os.now(), "server", text}); }

  const Program program_;
  ServedRegions regions_;
  State state_ = State::kServed;
  HeartbeatWatch heartbeat_;
  Redial redial_;
  UnservedPacer pacer_;
  TimePoint find_raised_{};  // when to check again whether a server that is away has raised a thread,
  TimePoint wait_until_{};   // and until when to check
  std::string refusal_;      // why the newest server is not this program's
};

}  // namespace ctn::runtime
