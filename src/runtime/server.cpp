#include "runtime/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "os/linux/process.h"
#include "os/thread_limit.h"
#include "runtime/control.h"
#include "runtime/socket_path.h"

namespace ctn::runtime {
namespace {

constexpr os::Poller::Key kListener = 0;
// Messages that are read from one client before the next has its turn.
constexpr int kMessagesATurn = 16;
constexpr Nanos kThreadSearchPeriod = std::chrono::milliseconds{100};
constexpr Nanos kGuardianCheckPeriod = std::chrono::seconds{1};
// A client that has not said hello by then is disconnected.
constexpr Nanos kHelloTimeout = std::chrono::seconds{5};
constexpr Nanos kHeartbeatPeriod = std::chrono::milliseconds{50};
// The gap after which programs take the server for stopped. At a real-time level the heartbeat is late only if the
// machine is; at the ordinary level it may have to wait for its turn.
constexpr Nanos kMaxHeartbeatGap = std::chrono::milliseconds{250};
constexpr Nanos kMaxOrdinaryHeartbeatGap = std::chrono::seconds{2};
// More programs than nodes make no sense; a few more come and go.
constexpr std::size_t kSpareClients = 64;

constexpr unsigned kOwnerOnly = 0600;
constexpr unsigned kAnyUser = 0666;  // each is asked who it is

}  // namespace

Result<std::unique_ptr<Server>> Server::open(config::AppFile file, os::Os& os, ServerOptions options) {
  Result<os::CpuSet> cpus = choose_cpus(os, options.scheduler.cpus);
  if (!cpus) return cpus.error();

  std::string path = options.socket;
  if (path.empty()) {
    const Result<std::string> usual = socket_to_serve(file.app.name);
    if (!usual) return usual.error();
    path = *usual;
  }
  const bool owner_only = options.users.empty() && os::current_user() != 0;
  Result<os::Listener> listener = os::Listener::open(path, owner_only ? kOwnerOnly : kAnyUser);
  if (!listener) return listener.error();
  Result<std::unique_ptr<os::Poller>> poller = os::Poller::make();
  if (!poller) return poller.error();
  const bool cut = options.scheduler.policy->cuts_subchains();
  file.app = policy::as_run_by(*options.scheduler.policy, std::move(file.app));
  Result<os::SharedMemory> memory =
      os::SharedMemory::create("catan", Region::size_for(file.app.graph, cpus->size(), file.text));
  if (!memory) return memory.error();
  Region region = Region::create(file.app.graph, cpus->size(), file.text, memory->bytes(), cut);

  std::unique_ptr<Server> server(new Server(std::move(file.app), os, options, std::move(*memory), std::move(region),
                                            std::move(*listener), std::move(*poller)));
  options.scheduler.guardian = true;
  server->has_heartbeat_ = options.scheduler.policy->follows_plan();
  Result<std::unique_ptr<Scheduler>> scheduler =
      Scheduler::create(server->app_, os, std::move(options.scheduler), std::move(*cpus), server->region_);
  if (!scheduler) return scheduler.error();
  server->scheduler_ = std::move(*scheduler);
  server->registry_ = std::make_unique<Registry>(os, *server->scheduler_);
  return server;
}

Server::Server(graph::App app, os::Os& os, ServerOptions options, os::SharedMemory memory, Region region,
               os::Listener listener, std::unique_ptr<os::Poller> poller)
    : app_(std::move(app)),
      os_(os),
      users_(std::move(options.users)),
      describe_(std::move(options.describe)),
      memory_(std::move(memory)),
      region_(std::move(region)),
      listener_(std::move(listener)),
      poller_(std::move(poller)) {}

Server::~Server() {
  if (started_) static_cast<void>(finish());
}

Status Server::start() {
  return os::within_thread_limit([this] { return start_all(); });
}

Status Server::start_all() {
  if (Status added = poller_->add(listener_.socket(), kListener); !added) return added;
  if (Status ready = scheduler_->prepare(); !ready) return ready;
  started_ = true;
  every(kThreadSearchPeriod, [this] { registry_->find_threads(); });
  every(OrdinaryThreads::kPeriod, [this] { registry_->look_at_ordinary_threads(os_.now()); });
  every(kGuardianCheckPeriod, [this] { scheduler_->check_guardian(); });
  every(kHelloTimeout, [this] { disconnect_silent(); });
  if (Status scheduled = scheduler_->start(); !scheduled) return scheduled;
  if (!has_heartbeat_) return Done{};
  // Programs may register, and this process be stopped, before the thread has begun.
  region_.heartbeat().max_heartbeat_gap.store(kMaxOrdinaryHeartbeatGap.count(), std::memory_order_release);
  heartbeat_ = os_.spawn("catan-heartbeat", [this] { send_heartbeats(); });
  return Done{};
}

// In a thread of its own.
void Server::send_heartbeats() {
  // Where it is permitted, above all fixed priorities, so that no run can keep it from saying that the server lives.
  const os::ThreadId self = os_.current_thread();
  const bool raised = os_.set_level(self, os::fixed_level(os::kFixedLevels - 1)).ok() ||
                      os_.set_level(self, os::Level::kDispatcher).ok();
  Heartbeat& heartbeat = region_.heartbeat();
  heartbeat.max_heartbeat_gap.store((raised ? kMaxHeartbeatGap : kMaxOrdinaryHeartbeatGap).count(),
                                    std::memory_order_release);
  while (heartbeat_stops_.load(std::memory_order_acquire) == 0) {
    heartbeat.beats.fetch_add(1, std::memory_order_release);
    os_.wait(heartbeat_stops_, 0, os_.now() + kHeartbeatPeriod);
  }
}

Status Server::watch(const os::Descriptor& descriptor, std::function<void()> act) {
  const Key key = next_key_;
  next_key_ += 2;
  if (Status added = poller_->add(descriptor, key); !added) return added;
  keys_of_watched_[descriptor.number()] = key;
  watched_[key] = std::move(act);
  return Done{};
}

void Server::forget(const os::Descriptor& descriptor) {
  poller_->remove(descriptor);
  watched_.erase(keys_of_watched_[descriptor.number()]);
}

void Server::stop() {
  stopping_.store(true);
  poller_->wake();
}

Status Server::finish() {
  if (!std::exchange(started_, false)) return Done{};
  scheduler_->end_scheduling();
  while (!clients_.empty()) disconnect(clients_.begin()->first, "the server ends");
  heartbeat_stops_.store(1, std::memory_order_release);
  os_.wake(heartbeat_stops_);
  heartbeat_.reset();
  return scheduler_->finish();
}

void Server::run() {
  while (!stopping_.exchange(false)) {
    const std::vector<Key> ready = poller_->wait(run_timed_calls());
    for (const Key key : ready) serve(key);
  }
}

void Server::serve(Key key) {
  if (key == kListener) return accept_client();
  if (const auto watched = watched_.find(key); watched != watched_.end()) {
    const std::function<void()> act = watched->second;  // it may forget itself
    return act();
  }
  // A client has two keys: its socket's, which is even, and its process's.
  const auto client = clients_.find(key & ~Key{1});
  if (client == clients_.end()) return;  // turned away just now
  if ((key & 1U) != 0) return disconnect(client->first, "its process has ended");
  receive_from(client->first, client->second);
}

bool Server::may_control(const os::Peer& peer) { return peer.user == 0 || peer.user == os::current_user(); }

bool Server::may_register(const os::Peer& peer) const {
  return may_control(peer) || std::find(users_.begin(), users_.end(), peer.user) != users_.end();
}

void Server::accept_client() {
  Result<std::optional<os::Connection>> accepted = listener_.accept();
  if (!accepted) {
    if (refused_++ == 0) scheduler_->notice("clients", accepted.error().message());
    return;
  }
  if (!*accepted) return;
  os::Connection connection = std::move(**accepted);
  const os::Peer peer = connection.peer();
  std::optional<Error> refusal;
  if (!may_register(peer)) {
    refusal = Error::caller(fmt::format("user {} may not register with this server", peer.user),
                            "let the server allow it: --allow-user");
  } else if (static_cast<int>(peer.process) == 0) {
    refusal = Error::caller("the kernel does not name the process: it is of another container",
                            "let both share the namespace of processes");
  } else if (clients_.size() >= app_.graph.nodes().size() + kSpareClients) {
    refusal = Error::caller("there are more programs than nodes already", "end some");
  }
  if (refusal) {
    if (refused_++ == 0) scheduler_->notice("clients", "turned away: " + refusal->message());
    static_cast<void>(connection.send(to_text(Status(*refusal))));
    return;
  }
  const Key key = next_key_;
  next_key_ += 2;
  Client client{std::move(connection), registry_->enter(peer.process, may_control(peer)), os_.now()};
  const bool watched =
      poller_->add(client.connection.socket(), key).ok() &&
      (!client.connection.process().valid() || poller_->add(client.connection.process(), key | 1U).ok());
  clients_.emplace(key, std::move(client));
  if (!watched) disconnect(key, "it cannot be watched");
}

void Server::receive_from(Key key, Client& client) {
  os::Message message;
  for (int count = 0; count < kMessagesATurn; ++count) {
    switch (client.connection.receive(message)) {
      case os::Arrival::kNothing:
        return;
      case os::Arrival::kClosed:
        // One that ends hangs up a moment before it counts as ended.
        return disconnect(
            key, os::is_ending(client.connection.peer().process) ? "its process has ended" : "its program has hung up");
      case os::Arrival::kMessage:
        if (!answer(client, message)) return disconnect(key, "it does not read the answers");
    }
  }
}

// Longer than a message may be.
Result<os::SharedMemory> Server::status() const {
  if (!describe_) return Error::caller("this server does not tell its status", "start it by `catan serve`");
  return to_memory(describe_(snapshot()));
}

bool Server::answer(Client& client, const os::Message& message) {
  if (message.truncated) {
    return client.connection.send(to_text(Status(Error::caller("a message was too long", "say less")))).ok();
  }
  const Registry::Answer answer = registry_->handle(client.program, message.sender.process, message.text);
  client.said_hello = client.said_hello || answer.attached == Registry::Attached::kRegion;
  switch (answer.attached) {
    case Registry::Attached::kNone:
      return client.connection.send(answer.text).ok();
    case Registry::Attached::kRegion:
      return client.connection.send(answer.text, &memory_.descriptor()).ok();
    case Registry::Attached::kStatus: {
      const Result<os::SharedMemory> described = status();
      if (!described) return client.connection.send(to_text(Status(described.error()))).ok();
      return client.connection.send(answer.text, &described->descriptor()).ok();
    }
    case Registry::Attached::kFlight: {
      const Result<os::Descriptor> kept = flight();
      if (!kept) return client.connection.send(to_text(Status(kept.error()))).ok();
      return client.connection.send(answer.text, &*kept).ok();
    }
  }
  return false;
}

void Server::disconnect(Key key, const std::string& why) {
  const auto client = clients_.find(key);
  registry_->leave(client->second.program, why);
  poller_->remove(client->second.connection.socket());
  if (client->second.connection.process().valid()) poller_->remove(client->second.connection.process());
  clients_.erase(client);
}

void Server::disconnect_silent() {
  const TimePoint now = os_.now();
  std::vector<Key> silent;
  for (const auto& [key, client] : clients_) {
    if (!client.said_hello && now - client.since > kHelloTimeout) silent.push_back(key);
  }
  for (const Key key : silent) disconnect(key, "it said nothing");
}

void Server::every(Nanos interval, std::function<void()> act) { timed_calls_.push_back({interval, std::move(act)}); }

// Returns when the next is due.
TimePoint Server::run_timed_calls() {
  TimePoint next = kNever;
  for (TimedCall& call : timed_calls_) {
    const TimePoint now = os_.now();
    if (now >= call.due) {
      call.due = now + call.interval;
      call.act();
    }
    next = std::min(next, call.due);
  }
  return next;
}

}  // namespace ctn::runtime
