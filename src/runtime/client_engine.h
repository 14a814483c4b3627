// The nodes of a process that a server (server.h) schedules; include/catan/client.h is this.
//
// It connects, finds its app in the region that the server hands out, and registers its nodes. One thread of its own,
// at the ordinary level, watches the server. While there is none it paces the heads of subchains that are this
// process's, at the period that the server wrote down last (or the head's fallback_rate): a run is triggered when the
// one before has ended, or when it has not for ten periods and a second. It dials again ten times a second, and one
// that refuses it more and more seldom, down to every five seconds; a new server of the same app has a new region, to
// which the nodes move with their next run once it has taken all of them.
//
// A server whose pulse has ceased (stopped, say) counts as gone until it beats again; then nodes register anew.
// Whenever there is none, this process gives its threads back the scheduling that they had when they registered: the
// server's guardian does so, too, but may have been killed with it.
//
// Units: Nanos. Thread safety: as include/catan/client.h says.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "config/app_file.h"
#include "os/linux/shared_memory.h"
#include "os/os.h"
#include "runtime/client_link.h"
#include "runtime/node_threads.h"
#include "runtime/pulse_watch.h"
#include "runtime/region.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

struct ClientEngineOptions {
  std::vector<std::string> sockets;
  std::string app;  // empty: any
  Nanos wait = std::chrono::seconds{10};
  std::function<void(const std::string&)> on_notice;
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
  // What one server gave.
  struct Served {
    os::SharedMemory memory;
    Region region;
  };
  struct Member {
    NodeId node;
    os::ThreadId thread;
    std::vector<os::ThreadId> others;  // that adopt_this_thread() named
    std::optional<os::SavedScheduling>
        before;  // the thread's, when it registered; none: a server had raised it by then
  };
  // A head that is paced without a server.
  struct Pacer {
    NodePort* port;
    Nanos period;
    TimePoint due;
    TimePoint ended;  // when a run was last known to have ended
  };

  ClientEngine(os::Os& os, ClientEngineOptions options);

  Status dial_first();
  Status dial_again();
  Status take_region(os::SharedMemory memory);
  Result<NodeId> own_node(std::string_view node) const;
  Status join(NodeId node, os::ThreadId thread);
  std::optional<os::SavedScheduling> before_serving(os::ThreadId thread) const;
  bool raised_by_server(os::ThreadId thread) const;
  Status join_again();
  Status ask_to_join(Member& member);
  void move_nodes_to(const Region& region);
  void forget_old_regions();

  void watch();
  bool server_lives(TimePoint now);
  void begin_alone(TimePoint now);
  void give_threads_back();
  TimePoint pace(TimePoint now);
  Nanos period_alone(const graph::Subchain& subchain, SubchainId id) const;
  void notice(const std::string& text) const;

  os::Os& os_;
  ClientEngineOptions options_;
  ClientLink link_;
  std::string text_;  // the app file's
  std::unique_ptr<graph::App> app_;
  std::list<Served> regions_;  // the newest last; older ones while a node is still in them
  std::unique_ptr<Wiring> wiring_;
  std::unique_ptr<NodeThreads> nodes_;

  std::mutex
      members_mutex_;  // guards the members, and regions_ where it is changed or others than the watching thread look
  std::vector<Member> members_;

  std::atomic<std::int32_t> service_{0};  // the watching thread's number
  std::atomic<std::uint32_t> ready_{0};
  std::atomic<bool> served_{false};
  std::atomic<bool> stopping_{false};
  std::vector<Pacer> pacers_;  // the watching thread's
  std::string refusal_;        // the watching thread's: why the newest server is not this program's
  Nanos redial_after_{0};      // the watching thread's
  PulseWatch pulse_;           // the watching thread's
  bool silent_ = false;        // the watching thread's: connected to a server whose pulse has ceased
  std::unique_ptr<os::Thread> watcher_;
};

}  // namespace ctn::runtime
