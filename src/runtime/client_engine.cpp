#include "runtime/client_engine.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/app_file.h"
#include "os/thread_limit.h"

namespace ctn::runtime {
namespace {

constexpr Nanos kConnectRetryDelay = std::chrono::milliseconds{20};
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
    : os_(os),
      options_(std::move(options)),
      link_(os, options_.sockets),
      notices_(os, options_.on_notice, false),
      registered_(os),
      watcher_(os) {}

ClientEngine::~ClientEngine() { stop(); }

Status ClientEngine::connect_first() {
  Status done = Done{};
  const Status made = os::within_thread_limit([&]() -> Status {
    watcher_.start("catan-link", [this, &done](std::optional<ServerWatch>& watch) {
      done = dial_first(watch);
      connected_.store(1, std::memory_order_release);
      os_.wake(connected_);
      if (!watch) return;
      watch->run();
      while (watcher_.sleep_until(kNever)) {
      }
      watch->leave();
    });
    while (connected_.load(std::memory_order_acquire) == 0) os_.wait(connected_, 0, kNever);
    if (done) notices_.start();
    return Done{};
  });
  return made ? done : made;
}

Status ClientEngine::dial_first(std::optional<ServerWatch>& watch) {
  const TimePoint deadline = os_.now() + options_.wait;
  for (;;) {
    Result<os::SharedMemory> memory = link_.converse()->dial(os_.current_thread(), {});
    if (memory) return take_first(std::move(*memory), watch);
    if (memory.error().kind() == ErrorKind::kCaller || os_.now() >= deadline) return memory.error();
    os_.sleep_until(std::min(deadline, os_.now() + kConnectRetryDelay));
  }
}

// The first region decides which app it is; later ones must be of the same.
Status ClientEngine::take_first(os::SharedMemory memory, std::optional<ServerWatch>& watch) {
  const Result<std::string> text = Region::text(memory.bytes());
  if (!text) return text.error();
  Result<graph::App> app = config::parse_app(*text, "the server's app file");
  if (!app) return app.error();
  if (!options_.app.empty() && options_.app != app->name) return another_app(app->name, options_.app);
  app_ = std::make_unique<graph::App>(std::move(*app));
  ServedRegions regions(*app_, *text);
  if (Status added = regions.add(std::move(memory)); !added) return added;
  wiring_ = std::make_unique<Wiring>(regions.newest_app(), os_, regions.newest());
  nodes_ = std::make_unique<NodeThreads>(*app_, os_, *wiring_);
  watch.emplace(ServerWatch::Program{.os = os_,
                                     .app = *app_,
                                     .link = link_,
                                     .wiring = *wiring_,
                                     .registered = registered_,
                                     .notices = notices_.notices(),
                                     .served = served_,
                                     .stopping = [this] { return watcher_.stopping(); }},
                std::move(regions));
  return Done{};
}

Status ClientEngine::start() {
  if (Status wired = wiring_->check(false); !wired) return wired;
  wiring_->close([this](const std::string& problem) { notices_.notices().add({os_.now(), "too-late", problem}); });
  if (Status made = os::within_thread_limit([this] { return start_nodes(); }); !made) {
    stop();
    return made;
  }
  nodes_->go();
  return Done{};
}

Status ClientEngine::start_nodes() {
  for (const auto& [node, thread] : nodes_->spawn()) {
    if (Status joined = join(node, thread); !joined) return joined;
  }
  return Done{};
}

// Threads are known here before the server is asked, so that their scheduling is restored whatever the answer is.
Status ClientEngine::join(NodeId node, os::ThreadId thread) {
  const std::unique_ptr<Conversation> conversation = link_.converse();
  registered_.add(node, thread);
  const Status joined = registered_.join({node, thread}, app_->graph.node(node).name, *conversation, {});
  if (!joined) registered_.remove(node, thread);
  return joined;
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
  const std::unique_ptr<Conversation> conversation = link_.converse();
  registered_.add_thread(*node, thread);
  const Status added = conversation->call(
      {.kind = Request::Kind::kAdd, .node = std::string(name), .thread = static_cast<std::int32_t>(thread)});
  // Where there is no server at this moment, the next one is told when nodes register with it.
  const bool later = !added && added.error().kind() == ErrorKind::kEnvironment && registered_.has(*node);
  if (added || later) return Done{};
  registered_.remove_thread(*node, thread);
  return added;
}

Status ClientEngine::share_thread(os::ThreadId thread) {
  Status shared = registered_.share(thread);
  if (shared) link_.wake();
  return shared;
}

void ClientEngine::stop() {
  watcher_.request_stop();
  link_.wake();
  if (notices_.is_current() || (nodes_ && nodes_->is_current())) {
    if (nodes_) nodes_->request_stop();
    return;
  }
  watcher_.join();
  if (nodes_) nodes_->stop();
  notices_.stop();
}

}  // namespace ctn::runtime
