#include "runtime/client_engine.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/app_file.h"

namespace ctn::runtime {
namespace {

constexpr Nanos kConnectRetryDelay = std::chrono::milliseconds{20};
// How often, and for how long after a server went away, we look whether it raised a thread all the same: as long as its
// guardian waits for it.
constexpr Nanos kRaisedSearchPeriod = std::chrono::milliseconds{20};
constexpr Nanos kLongestCall = std::chrono::seconds{10};

Error another_app(const std::string& served, const std::string& wanted) {
  return Error::environment(fmt::format("the server schedules app {}, not {}", served, wanted),
                            "connect to the server of the app, or start one");
}

}  // namespace

Result<std::unique_ptr<ClientEngine>> ClientEngine::connect(os::Os& os, ClientEngineOptions options) {
  std::unique_ptr<ClientEngine> engine(new ClientEngine(os, std::move(options)));
  if (Status dialled = engine->connect_first(); !dialled) return dialled.error();
  return engine;
}

ClientEngine::ClientEngine(os::Os& os, ClientEngineOptions options)
    : os_(os), options_(std::move(options)), link_(os, options_.sockets), notices_(os, options_.on_notice, false), registered_(os) {}

ClientEngine::~ClientEngine() { stop(); }

Status ClientEngine::connect_first() {
  // The thread that serves the connection is named in the first message, so it is there before.
  watcher_ = os_.spawn("catan-link", [this] {
    service_.store(static_cast<std::int32_t>(os_.current_thread()));
    while (ready_.load(std::memory_order_acquire) == 0) os_.wait(ready_, 0, kNever);
    watch();
  });
  while (service_.load() == 0) os_.sleep_until(os_.now() + std::chrono::microseconds{100});
  const TimePoint deadline = os_.now() + options_.wait;
  Status done = Done{};
  for (;;) {
    Result<os::SharedMemory> memory = link_.converse().dial(os::ThreadId{service_.load()});
    if (memory) {
      done = take_first(std::move(*memory));
      break;
    }
    done = memory.error();
    if (memory.error().kind() == ErrorKind::kCaller || os_.now() >= deadline) break;
    os_.sleep_until(std::min(deadline, os_.now() + kConnectRetryDelay));
  }
  if (done) {
    begin_heartbeat();
    served_.store(true);
  } else {
    stopping_.store(true);
  }
  ready_.store(1, std::memory_order_release);
  os_.wake(ready_);
  return done;
}

// The first region decides which app it is; later ones must be of the same.
Status ClientEngine::take_first(os::SharedMemory memory) {
  const Result<std::string> text = Region::text(memory.bytes());
  if (!text) return text.error();
  Result<graph::App> app = config::parse_app(*text, "the server's app file");
  if (!app) return app.error();
  if (!options_.app.empty() && options_.app != app->name) return another_app(app->name, options_.app);
  app_ = std::make_unique<graph::App>(std::move(*app));
  ServedRegions regions(*app_, *text);
  if (Status added = regions.add(std::move(memory)); !added) return added;
  watch_.emplace(std::move(regions));
  wiring_ = std::make_unique<Wiring>(*app_, os_, watch_->regions.newest());
  nodes_ = std::make_unique<NodeThreads>(*app_, os_, *wiring_);
  return Done{};
}

Status ClientEngine::start() {
  if (Status wired = wiring_->check(false); !wired) return wired;
  for (const auto& [node, thread] : nodes_->spawn()) {
    if (Status joined = join(node, thread); !joined) {
      stop();
      return joined;
    }
  }
  nodes_->go();
  return Done{};
}

// The thread is registered here before the server is asked, so that its scheduling is restored whatever the answer is.
Status ClientEngine::join(NodeId node, os::ThreadId thread) {
  const Conversation conversation = link_.converse();
  registered_.add(node, thread);
  const Status joined = request_join(conversation, {node, thread, {}, {}});
  if (!joined) registered_.remove(node, thread);
  return joined;
}

Status ClientEngine::request_join(const Conversation& conversation, const ClientMembers::RegisteredNode& registered,
                                  const Meanwhile& meanwhile) {
  const std::string& name = app_->graph.node(registered.node).name;
  const auto ask = [&](Request::Kind kind, os::ThreadId thread) {
    return conversation.call({.kind = kind, .node = name, .thread = static_cast<std::int32_t>(thread)}, meanwhile);
  };
  if (Status joined = ask(Request::Kind::kJoin, registered.thread); !joined) return joined;
  for (const os::ThreadId other : registered.others) {
    Status added = ask(Request::Kind::kAdd, other);
    if (!added && added.error().kind() != ErrorKind::kCaller) return added;
    if (!added) registered_.remove_thread(registered.node, other);  // it has ended meanwhile
  }
  return Done{};
}

Result<NodeId> ClientEngine::own_node(std::string_view name) const {
  const std::optional<NodeId> node = app_->graph.find_node(name);
  if (node && !app_->graph.node(*node).external) return *node;
  return Error::caller(fmt::format("app {} has no node '{}' of its own", app_->name, name),
                       "use a name from its nodes section that is not external");
}

Result<NodePort*> ClientEngine::attach(std::string_view name) {
  const Result<NodeId> node = own_node(name);
  if (!node) return node.error();
  if (Status joined = join(*node, os_.current_thread()); !joined) return joined.error();
  return wiring_->port(*node);
}

Status ClientEngine::adopt_this_thread(std::string_view name) {
  const Result<NodeId> node = own_node(name);
  if (!node) return node.error();
  const os::ThreadId thread = os_.current_thread();
  const Conversation conversation = link_.converse();
  const Status added = conversation.call(
      {.kind = Request::Kind::kAdd, .node = std::string(name), .thread = static_cast<std::int32_t>(thread)});
  // Where there is no server at this moment, the next one is told when nodes register with it.
  const bool later = !added && added.error().kind() == ErrorKind::kEnvironment && registered_.has(*node);
  if (!added && !later) return added;
  registered_.add_thread(*node, thread);
  return Done{};
}

void ClientEngine::stop() {
  if (!watcher_) return;
  stopping_.store(true);
  link_.wake();
  watcher_->join();
  watcher_.reset();
  // The threads' scheduling is restored before they end.
  bool all_left = true;
  {
    const Conversation conversation = link_.converse();
    for (const ClientMembers::RegisteredNode& registered : registered_.all()) {
      const std::string& name = app_->graph.node(registered.node).name;
      all_left = conversation.call({.kind = Request::Kind::kLeave, .node = name}).ok() && all_left;
    }
  }
  if (!all_left) registered_.restore_threads(watch_->regions.newest());
  link_.hang_up();
  served_.store(false);
  for (const ClientMembers::RegisteredNode& registered : registered_.all()) wiring_->port(registered.node)->stop();
  if (nodes_) nodes_->stop();
}

// --- The watching thread ---

void ClientEngine::watch() {
  TimePoint wake = os_.now();
  while (!stopping_.load()) {
    const Result<bool> gone = link_.wait(wake);
    if (!gone) notices_.add("server", "it cannot be watched: " + gone.error().message());
    if (!gone) break;
    const TimePoint now = os_.now();
    if (*gone || (served() && !server_alive(now))) lose_server(now, *gone);
    if (served()) watch_->regions.drop_old(*wiring_, running());
    wake = served() ? watch_->heartbeat.next_check() : run_without_server(now);
    notices_.deliver();
  }
  notices_.deliver();
}

void ClientEngine::begin_heartbeat() {
  watch_->heartbeat.begin(os_.now(), watch_->regions.newest().heartbeat().beats.load(std::memory_order_acquire));
}

bool ClientEngine::server_alive(TimePoint now) {
  const Heartbeat& heartbeat = watch_->regions.newest().heartbeat();
  return watch_->heartbeat.alive(now, heartbeat.beats.load(std::memory_order_acquire),
                                 Nanos{heartbeat.max_heartbeat_gap.load(std::memory_order_acquire)});
}

// `gone`: it has ended, has closed the connection, or did not answer. Otherwise its heartbeat has ceased, but the
// connection is there.
void ClientEngine::lose_server(TimePoint now, bool gone) {
  const bool was_served = served_.exchange(false, std::memory_order_acq_rel);
  watch_->silent = !gone;
  gone ? watch_->redial.at_once(now) : watch_->redial.not_now();
  if (was_served) {
    restore_threads(now);
    std::vector<UnservedPacer::Head> heads;
    for (const ClientMembers::RegisteredNode& registered : registered_.all()) {
      const std::optional<SubchainId> id = app_->graph.node(registered.node).subchain;
      if (!id || app_->graph.subchain(*id).nodes.front() != registered.node) continue;
      heads.push_back(
          {wiring_->port(registered.node), period_without_server(app_->graph, *id, watch_->regions.newest())});
    }
    watch_->pacer.begin(now, heads);
  }
  const std::string rates = "; nodes go on at the rates that were planned last";
  notices_.add("server", (gone ? "it is gone" : "it does nothing any more") + (was_served ? rates : ""));
}

void ClientEngine::restore_threads(TimePoint now) {
  registered_.restore_threads(watch_->regions.newest());
  watch_->find_raised = now + kRaisedSearchPeriod;
  watch_->wait_until = now + kLongestCall;
}

// While no server schedules the nodes. Returns when it is to be called again.
TimePoint ClientEngine::run_without_server(TimePoint now) {
  TimePoint wake = pace_and_restore(now);
  if (watch_->silent) {
    if (!server_alive(now)) return std::min(wake, watch_->heartbeat.next_check());
    link_.hang_up();
    watch_->silent = false;
    watch_->redial.at_once(now);
  }
  if (now >= watch_->redial.due() && reconnect()) return watch_->heartbeat.next_check();
  return std::min(wake, watch_->redial.due());
}

// Triggers nodes that are due, and restores threads that a server has raised all the same. Returns when it is to be
// called again.
TimePoint ClientEngine::pace_and_restore(TimePoint now) {
  const TimePoint wake = watch_->pacer.pace_heads(now);
  if (now >= watch_->wait_until) return wake;
  if (now >= watch_->find_raised) {
    watch_->find_raised = now + kRaisedSearchPeriod;
    const Region& region = watch_->regions.newest();
    if (registered_.any_raised(region)) registered_.restore_threads(region);
  }
  return std::min(wake, watch_->find_raised);
}

// True: there is a server again, and it has all nodes.
bool ClientEngine::reconnect() {
  const Dialled dialled = dial_and_join();
  if (dialled.done) {
    watch_->refusal.clear();
    watch_->redial.not_now();
    served_.store(true, std::memory_order_release);
    notices_.add("server", "there is one again, and it schedules the nodes");
    return true;
  }
  link_.hang_up();
  const TimePoint now = os_.now();
  if (dialled.may_have_raised) restore_threads(now);
  if (dialled.done.error().kind() == ErrorKind::kEnvironment && (!dialled.answered || dialled.known)) {
    watch_->redial.unanswered(now);
  } else {
    watch_->redial.refused(now, dialled.known);
  }
  const std::string why = dialled.done.error().message();
  if (dialled.answered && std::exchange(watch_->refusal, why) != why) {
    notices_.add("server", "there is one, but nodes go on without it: " + why);
  }
  return false;
}

ClientEngine::Dialled ClientEngine::dial_and_join() {
  const Conversation conversation = link_.converse();
  // It may be one that never answers.
  const Meanwhile meanwhile = [this]() -> std::optional<TimePoint> {
    if (stopping_.load()) return std::nullopt;
    return pace_and_restore(os_.now());
  };
  Result<os::SharedMemory> memory = conversation.dial(os::ThreadId{service_.load()}, meanwhile);
  if (!memory) return {.done = memory.error(), .answered = memory.error().kind() == ErrorKind::kCaller};
  // A server that was stopped and goes on has the region in which the nodes still are.
  const bool known = watch_->regions.is_newest(*memory);
  return {.done = take_over(conversation, std::move(*memory), known),
          .answered = true,
          .known = known,
          .may_have_raised = true};
}

Status ClientEngine::take_over(const Conversation& conversation, os::SharedMemory memory, bool known) {
  if (!known) {
    if (Status added = watch_->regions.add(std::move(memory)); !added) return added;
  }
  begin_heartbeat();
  Status joined = rejoin(conversation);
  if (!joined && !known) watch_->regions.drop_newest();
  return joined;
}

// All or none: a server that refuses one of the nodes gets none of them, and nothing is written into its region.
Status ClientEngine::rejoin(const Conversation& conversation) {
  // Nodes are run until they are taken over, and a server that is stopped once more is not waited for.
  const Meanwhile meanwhile = [this]() -> std::optional<TimePoint> {
    const TimePoint now = os_.now();
    if (!server_alive(now)) return std::nullopt;
    return std::min(watch_->pacer.pace_heads(now), watch_->heartbeat.next_check());
  };
  registered_.update_saved_scheduling();
  for (const ClientMembers::RegisteredNode& registered : registered_.all()) {
    if (Status joined = request_join(conversation, registered, meanwhile); !joined) return joined;
  }
  watch_->regions.move_nodes(*wiring_, running());
  return Done{};
}

std::vector<NodeId> ClientEngine::running() const {
  std::vector<NodeId> nodes;
  for (const ClientMembers::RegisteredNode& registered : registered_.all()) nodes.push_back(registered.node);
  return nodes;
}

}  // namespace ctn::runtime
