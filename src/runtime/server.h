// Schedules an app whose nodes are other processes', `catan serve`: a scheduler over shared memory, and a Unix socket
// at which programs register the nodes that they run (client_engine.h is their side).
//
// Who may register: root, the user that the server runs as, and the users that are named. Who may control the server,
// that is change weights, bounds and CPUs or ask for its status: root and the user that it runs as (of the process that
// connected, as the kernel knows it). What a program says is checked (registry.h), what it writes into the shared
// memory is not trusted (region.h), and nothing here waits for it: a program that floods the socket, says nothing, or
// belongs to another user is disconnected. If the server is killed, a guardian restores the scheduling of the nodes'
// threads. If it is stopped, programs notice that its heartbeat stops, and go on by themselves.
//
// Thread safety: open, start, run, finish, watch from one thread; stop and snapshot from any.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "catan/snapshot.h"
#include "config/app_file.h"
#include "os/linux/connection.h"
#include "os/linux/listener.h"
#include "os/linux/poller.h"
#include "os/linux/shared_memory.h"
#include "os/os.h"
#include "runtime/registry.h"
#include "runtime/scheduler.h"

namespace ctn::runtime {

struct ServerOptions {
  SchedulerOptions scheduler;
  std::string socket;                                      // empty: socket_to_serve()
  std::vector<std::uint32_t> users;                        // who may register, besides root and the server's own user
  std::function<std::string(const Snapshot&)> describe{};  // the answer to a request for the status; else there is none
};

class Server {
 public:
  // Errors: CPUs that are not there (kCaller); no shared memory, another server at the socket (kEnvironment).
  static Result<std::unique_ptr<Server>> open(config::AppFile file, os::Os& os, ServerOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const graph::App& app() const { return app_; }
  const std::string& socket() const { return listener_.path(); }

  Status start();
  // `act` is called in run() whenever the descriptor is readable, until it is forgotten.
  Status watch(const os::Descriptor& descriptor, std::function<void()> act);
  void forget(const os::Descriptor& descriptor);
  // `act` is called in run(), so often. Before run().
  void every(Nanos interval, std::function<void()> act);
  // Serves until stop(). After end_scheduling() nothing is scheduled any more, but messages of programs are still
  // answered.
  void run();
  void end_scheduling() { scheduler_->end_scheduling(); }
  void stop();
  // Restores the scheduling of all threads. Returns the first error of the record.
  Status finish();

  bool warmed_up() const { return scheduler_->warmed_up(); }
  Snapshot snapshot() const { return scheduler_->snapshot(); }
  // As the scheduler has it.
  Result<os::Descriptor> flight() const { return scheduler_->flight(); }

 private:
  Status start_all();

  struct Client {
    os::Connection connection;
    Registry::ProgramId program;
    TimePoint since;
    bool said_hello = false;
  };
  using Key = os::Poller::Key;

  Server(graph::App app, os::Os& os, ServerOptions options, os::SharedMemory memory, Region region,
         os::Listener listener, std::unique_ptr<os::Poller> poller);

  void serve(Key key);
  void accept_client();
  static bool may_control(const os::Peer& peer);
  bool may_register(const os::Peer& peer) const;
  void receive_from(Key key, Client& client);
  Result<os::SharedMemory> status() const;
  bool answer(Client& client, const os::Message& message);
  void disconnect(Key key, const std::string& why);
  void disconnect_silent();
  TimePoint run_timed_calls();
  void send_heartbeats();

  graph::App app_;
  os::Os& os_;
  const std::vector<std::uint32_t> users_;
  const std::function<std::string(const Snapshot&)> describe_;
  os::SharedMemory memory_;
  Region region_;
  os::Listener listener_;
  std::unique_ptr<os::Poller> poller_;
  std::unique_ptr<Scheduler> scheduler_;
  std::unique_ptr<Registry> registry_;
  std::map<Key, Client> clients_;  // by the even of its two keys
  std::map<Key, std::function<void()>> watched_;
  std::map<int, Key> keys_of_watched_;
  struct TimedCall {
    Nanos interval;
    std::function<void()> act;
    TimePoint due{};
  };
  std::vector<TimedCall> timed_calls_;
  Key next_key_ = 2;
  std::uint64_t refused_ = 0;
  std::atomic<bool> stopping_{false};
  bool started_ = false;
  // Only for policies that follow a plan: the heartbeat's thread has the level of their controllers.
  bool has_heartbeat_ = false;
  std::atomic<std::uint32_t> heartbeat_stops_{0};
  std::unique_ptr<os::Thread> heartbeat_;
};

}  // namespace ctn::runtime
