// The nodes of a process that a server (server.h) schedules; include/catan/client.h is this.
//
// It connects, finds its app in the region that the server hands out, and registers its nodes. One thread of its own,
// at the ordinary level, watches the server:
//   while there is one     it looks at the server's heartbeat (heartbeat_watch.h). A server that is stopped has none,
//                          and counts as gone until it goes on
//   while there is none    it runs the subchains whose heads are this process's at their own rates (unserved_pacer.h),
//                          restores the scheduling of threads (client_members.h), and connects again (redial.h)
//   when one is back       it registers all nodes again, all or none, and moves them to the server's region
//                          (served_regions.h)
//
// The program restores the scheduling of its threads although the server's guardian does the same: the guardian may
// have been killed with the server, and it does nothing while the server is only stopped. A stopped server may have
// been in a call that raises a thread, which takes effect later; so for some seconds the program checks again whether a
// thread is raised.
//
// Units: Nanos. Thread safety: as include/catan/client.h says.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "os/os.h"
#include "runtime/client_link.h"
#include "runtime/client_members.h"
#include "runtime/heartbeat_watch.h"
#include "runtime/node_threads.h"
#include "runtime/notices.h"
#include "runtime/redial.h"
#include "runtime/served_regions.h"
#include "runtime/unserved_pacer.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

struct ClientEngineOptions {
  std::vector<std::string> sockets;
  std::string app;  // empty: any
  Nanos wait = std::chrono::seconds{10};
  Notices::Callback on_notice;
};

class ClientEngine {
 public:
  // `os` outlives it.
  static Result<std::unique_ptr<ClientEngine>> connect(os::Os& os, ClientEngineOptions options);
  ~ClientEngine();
  ClientEngine(const ClientEngine&) = delete;
  ClientEngine& operator=(const ClientEngine&) = delete;

  const graph::App& app() const { return *app_; }
  Wiring& wiring() { return *wiring_; }

  Status start();
  void stop();
  // The calling thread is the node's. Good until this ends.
  Result<NodePort*> attach(std::string_view node);
  Status adopt_this_thread(std::string_view node);
  bool served() const { return served_.load(std::memory_order_acquire); }

 private:
  using Conversation = ClientLink::Conversation;
  using Meanwhile = ClientLink::Meanwhile;

  ClientEngine(os::Os& os, ClientEngineOptions options);

  Status connect_first();
  Status take_first(os::SharedMemory memory);
  Result<NodeId> own_node(std::string_view node) const;
  Status join(NodeId node, os::ThreadId thread);
  Status request_join(const Conversation& conversation, const ClientMembers::RegisteredNode& registered,
                      const Meanwhile& meanwhile = {});

  // Only the watching thread, once it runs.
  struct Watch {
    explicit Watch(ServedRegions served) : regions(std::move(served)) {}

    ServedRegions regions;
    HeartbeatWatch heartbeat;
    bool silent = false;  // connected to a server that has no heartbeat any more
    Redial redial;
    UnservedPacer pacer;
    TimePoint find_raised{};  // when to check again whether a server that is away has raised a thread,
    TimePoint wait_until{};   // and until when to check
    std::string refusal;      // why the newest server is not this program's
  };
  void watch();
  bool server_alive(TimePoint now);
  void begin_heartbeat();
  void lose_server(TimePoint now, bool gone);
  void restore_threads(TimePoint now);
  TimePoint run_without_server(TimePoint now);
  TimePoint pace_and_restore(TimePoint now);
  struct Dialled {
    Status done;
    bool answered = false;         // a server was there
    bool known = false;            // it is the one of before
    bool may_have_raised = false;  // some nodes may have joined before it refused others
  };
  bool reconnect();
  Dialled dial_and_join();
  Status take_over(const Conversation& conversation, os::SharedMemory memory, bool known);
  Status rejoin(const Conversation& conversation);
  std::vector<NodeId> running() const;

  os::Os& os_;
  ClientEngineOptions options_;
  ClientLink link_;
  Notices notices_;  // delivered by the watching thread
  std::unique_ptr<graph::App> app_;
  std::optional<Watch> watch_;  // its regions outlive the nodes, which use them until they end
  std::unique_ptr<Wiring> wiring_;
  std::unique_ptr<NodeThreads> nodes_;
  ClientMembers registered_;

  std::atomic<std::int32_t> service_{0};  // the watching thread's number
  std::atomic<std::uint32_t> ready_{0};
  std::atomic<bool> served_{false};
  std::atomic<bool> stopping_{false};
  std::unique_ptr<os::Thread> watcher_;
};

}  // namespace ctn::runtime
