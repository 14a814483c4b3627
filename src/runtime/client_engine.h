// The nodes of a process that a server (server.h) schedules; include/catan/client.h is this.
//
// It connects, finds its app in the region that the server hands out, and registers its nodes. One thread of its own,
// at the ordinary level, connects, watches the server, and moves the nodes to the next one (server_watch.h); another
// delivers notices (notice_thread.h).
//
// Units: Nanos. Thread safety: as include/catan/client.h says.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "driver/notices.h"
#include "os/os.h"
#include "runtime/client_link.h"
#include "runtime/client_nodes.h"
#include "runtime/node_threads.h"
#include "runtime/notice_thread.h"
#include "runtime/owning_thread.h"
#include "runtime/server_watch.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

struct ClientEngineOptions {
  std::vector<std::string> sockets;
  std::string app;  // empty: any
  Nanos wait = std::chrono::seconds{10};
  driver::Notices::Callback on_notice;
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
  // Called by on_notice or a node's function, it returns at once, and what it does goes on meanwhile; that on_notice
  // has been told all is then for the next call to wait for, or for the end of this.
  void stop();
  // The calling thread is the node's. Good until this ends.
  Result<NodePort*> attach(std::string_view node);
  Status adopt_this_thread(std::string_view node);
  // Works for all nodes of this program. The server is told by the thread that watches it; the caller, which may be a
  // middleware's thread, never waits for that.
  Status share_thread(os::ThreadId thread);
  bool served() const { return served_.load(std::memory_order_acquire); }

 private:
  ClientEngine(os::Os& os, ClientEngineOptions options);

  Status connect_first();
  Status dial_first(std::optional<ServerWatch>& watch);
  Status take_first(os::SharedMemory memory, std::optional<ServerWatch>& watch);
  Status start_nodes();
  Result<NodeId> own_node(std::string_view node) const;
  Status join(NodeId node, os::ThreadId thread);

  os::Os& os_;
  ClientEngineOptions options_;
  ClientLink link_;
  NoticeThread notices_;
  ClientNodes registered_;
  std::atomic<bool> served_{false};
  std::atomic<std::uint32_t> connected_{0};  // 1: it has succeeded or failed; from then on what follows stays
  std::unique_ptr<graph::App> app_;
  OwningThread<std::optional<ServerWatch>> watcher_;  // has the regions, which the nodes use until they end
  std::unique_ptr<Wiring> wiring_;
  std::unique_ptr<NodeThreads> nodes_;
};

}  // namespace ctn::runtime
