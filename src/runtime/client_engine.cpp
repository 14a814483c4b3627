#include "runtime/client_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ctn::runtime {
namespace {

constexpr Nanos kRedial = std::chrono::milliseconds{100};
constexpr Nanos kLongestRedial = std::chrono::seconds{5};
// Whether a server that was stopped goes on.
constexpr Nanos kLookForLife = std::chrono::milliseconds{20};
constexpr Nanos kFirstDial = std::chrono::milliseconds{20};
// Where nothing says how often a subchain is to run.
constexpr Nanos kUnknownPeriod = std::chrono::milliseconds{100};
constexpr Nanos kShortestPeriod = std::chrono::microseconds{100};
constexpr Nanos kLongestPeriod = std::chrono::seconds{100};
// A run that has not ended after so many periods, and a second, has nobody left to end it.
constexpr int kLostPeriods = 10;
constexpr Nanos kLostAfter = std::chrono::seconds{1};

Error another_app(const std::string& served, const std::string& wanted) {
  return Error::environment(fmt::format("the server schedules app {}, not {}", served, wanted),
                            "connect to the server of the app, or start one");
}

}  // namespace

Result<std::unique_ptr<ClientEngine>> ClientEngine::connect(os::Os& os, ClientEngineOptions options) {
  std::unique_ptr<ClientEngine> engine(new ClientEngine(os, std::move(options)));
  if (Status dialled = engine->dial_first(); !dialled) return dialled.error();
  return engine;
}

ClientEngine::ClientEngine(os::Os& os, ClientEngineOptions options)
    : os_(os), options_(std::move(options)), link_(os, options_.sockets) {}

ClientEngine::~ClientEngine() { stop(); }

Status ClientEngine::dial_first() {
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
    Result<os::SharedMemory> memory = link_.dial(os::ThreadId{service_.load()});
    if (memory) {
      done = take_region(std::move(*memory));
      break;
    }
    done = memory.error();
    if (memory.error().kind() == ErrorKind::kCaller || os_.now() >= deadline) break;
    os_.sleep_until(std::min(deadline, os_.now() + kFirstDial));
  }
  if (done) {
    pulse_.begin(os_.now(), regions_.back().region.pulse().beats.load(std::memory_order_acquire));
    served_.store(true);
  } else {
    stopping_.store(true);
  }
  ready_.store(1, std::memory_order_release);
  os_.wake(ready_);
  return done;
}

// The first region decides which app it is; later ones must be of the same.
Status ClientEngine::take_region(os::SharedMemory memory) {
  const Result<std::string> text = Region::text(memory.bytes());
  if (!text) return text.error();
  if (!app_) {
    Result<graph::App> app = config::parse_app(*text, "the server's app file");
    if (!app) return app.error();
    if (!options_.app.empty() && options_.app != app->name) return another_app(app->name, options_.app);
    app_ = std::make_unique<graph::App>(std::move(*app));
    text_ = *text;
  }
  if (*text != text_) return another_app("of another file", app_->name);
  Result<Region> region = Region::open(app_->graph, memory.bytes());
  if (!region) return region.error();
  const std::lock_guard lock(members_mutex_);
  regions_.push_back({std::move(memory), std::move(*region)});
  if (!wiring_) {
    wiring_ = std::make_unique<Wiring>(*app_, os_, regions_.back().region);
    nodes_ = std::make_unique<NodeThreads>(*app_, os_, *wiring_);
  }
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

Status ClientEngine::join(NodeId node, os::ThreadId thread) {
  const std::lock_guard lock(members_mutex_);
  Member member{node, thread, {}, before_serving(thread)};
  if (Status joined = ask_to_join(member); !joined) return joined;
  members_.push_back(std::move(member));
  return Done{};
}

// A thread that a server has found and raised before the program named it: only that server knows what it had.
std::optional<os::SavedScheduling> ClientEngine::before_serving(os::ThreadId thread) const {
  const Result<os::SavedScheduling> saved = os_.save_scheduling(thread);
  if (!saved || raised_by_server(thread)) return std::nullopt;
  return *saved;
}

// By what a raised thread looks like; real-time threads of the program's own seldom have the flag.
bool ClientEngine::raised_by_server(os::ThreadId thread) const {
  const Result<os::Level> level = os_.level(thread);
  if (!level || *level == os::Level::kOrdinary) return false;
  const Result<os::SavedScheduling> found = os_.save_scheduling(thread);
  return found && found->reset_on_fork;
}

// Under the lock, which keeps a new server from taking over half of what is asked for.
Status ClientEngine::ask_to_join(Member& member) {
  const std::string& name = app_->graph.node(member.node).name;
  const Status joined =
      link_.call({.kind = Request::Kind::kJoin, .node = name, .thread = static_cast<std::int32_t>(member.thread)});
  if (!joined) return joined;
  // Those that have ended meanwhile are refused.
  std::erase_if(member.others, [&](os::ThreadId other) {
    const Status added =
        link_.call({.kind = Request::Kind::kAdd, .node = name, .thread = static_cast<std::int32_t>(other)});
    return !added && added.error().kind() == ErrorKind::kCaller;
  });
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
  const std::lock_guard lock(members_mutex_);
  const auto member =
      std::find_if(members_.begin(), members_.end(), [&](const Member& each) { return each.node == *node; });
  const Status added =
      link_.call({.kind = Request::Kind::kAdd, .node = std::string(name), .thread = static_cast<std::int32_t>(thread)});
  // Where there is no server at this moment, the next is told.
  const bool later = !added && added.error().kind() == ErrorKind::kEnvironment && member != members_.end();
  if (!added && !later) return added;
  if (member != members_.end()) member->others.push_back(thread);
  return Done{};
}

void ClientEngine::stop() {
  if (!watcher_) return;
  stopping_.store(true);
  link_.wake();
  watcher_->join();
  watcher_.reset();
  // First they get their scheduling back, then they end.
  for (const Member& member : members_) {
    static_cast<void>(link_.call({.kind = Request::Kind::kLeave, .node = app_->graph.node(member.node).name}));
  }
  link_.hang_up();
  served_.store(false);
  for (const Member& member : members_) wiring_->port(member.node)->stop();
  if (nodes_) nodes_->stop();
}

// --- The watching thread ---

void ClientEngine::watch() {
  TimePoint wake = os_.now();
  TimePoint redial = kNever;
  while (!stopping_.load()) {
    const Result<bool> gone = link_.wait(wake);
    if (!gone) return notice("server: it cannot be watched: " + gone.error().message());
    const TimePoint now = os_.now();
    if (*gone || (served() && !server_lives(now))) {
      const bool was_served = served_.exchange(false, std::memory_order_acq_rel);
      silent_ = !*gone;
      redial = silent_ ? kNever : now;
      if (was_served) begin_alone(now);
      if (silent_) {
        notice("server: it does nothing any more; nodes go on at the rates that were planned last");
      } else {
        notice(was_served ? "server: it is gone; nodes go on at the rates that were planned last"
                          : "server: it is gone");
      }
    }
    if (served()) {
      if (regions_.size() > 1) forget_old_regions();
      wake = pulse_.next_look();
      continue;
    }
    wake = pace(now);
    if (silent_) {
      wake = std::min(wake, now + kLookForLife);
      if (!server_lives(now)) continue;
      link_.hang_up();
      silent_ = false;
      redial = now;
    }
    if (now >= redial) {
      if (dial_again()) {
        redial = kNever;
        wake = pulse_.next_look();
        notice("server: there is one again, and nodes are in its hands");
        continue;
      }
      redial = os_.now() + redial_after_;
    }
    wake = std::min(wake, redial);
  }
}

bool ClientEngine::server_lives(TimePoint now) {
  const Pulse& pulse = regions_.back().region.pulse();
  return pulse_.lives(now, pulse.beats.load(std::memory_order_acquire),
                      Nanos{pulse.longest_pause.load(std::memory_order_acquire)});
}

Nanos ClientEngine::period_alone(const graph::Subchain& subchain, SubchainId id) const {
  const Nanos planned{regions_.back().region.signal(id).period.load(std::memory_order_relaxed)};
  if (planned > Nanos{0}) return std::clamp(planned, kShortestPeriod, kLongestPeriod);
  const std::optional<Rate> fallback = app_->graph.node(subchain.nodes.front()).fallback_rate;
  return fallback ? to_nanos(fallback->period()) : kUnknownPeriod;
}

void ClientEngine::begin_alone(TimePoint now) {
  pacers_.clear();
  give_threads_back();
  const std::lock_guard lock(members_mutex_);
  for (const Member& member : members_) {
    const std::optional<SubchainId> id = app_->graph.node(member.node).subchain;
    if (!id || app_->graph.subchain(*id).nodes.front() != member.node) continue;
    const Nanos period = period_alone(app_->graph.subchain(*id), *id);
    pacers_.push_back({wiring_->port(member.node), period, now, now});
  }
}

// Those that the server raised: the members, and what the region lists beside them, which a server has found by itself.
// The region may hold anything, so only this process's own are looked at; those of whom nobody here knows what they had
// become ordinary, and else stay as the guardian left them.
void ClientEngine::give_threads_back() {
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return;
  const auto lives = [&](os::ThreadId thread) { return std::binary_search(living->begin(), living->end(), thread); };
  const std::lock_guard lock(members_mutex_);
  for (const Member& member : members_) {
    const NodeCell& cell = regions_.back().region.node(member.node);
    for (const std::atomic<std::int32_t>& listed : cell.thread) {
      const os::ThreadId thread{listed.load(std::memory_order_acquire)};
      if (thread == member.thread || !lives(thread)) continue;
      if (raised_by_server(thread)) static_cast<void>(os_.set_level(thread, os::Level::kOrdinary));
      if (member.before) static_cast<void>(os_.set_affinity(thread, member.before->affinity));
    }
    if (!lives(member.thread)) continue;
    if (member.before) {
      static_cast<void>(os_.restore_scheduling(member.thread, *member.before));
    } else if (raised_by_server(member.thread)) {
      static_cast<void>(os_.set_level(member.thread, os::Level::kOrdinary));
    }
  }
}

// Returns when to be called again.
TimePoint ClientEngine::pace(TimePoint now) {
  TimePoint next = kNever;
  for (Pacer& pacer : pacers_) {
    if (now >= pacer.due) {
      if (pacer.port->trigger_alone()) {
        pacer.ended = now;
      } else if (now - pacer.ended > kLostPeriods * pacer.period && now - pacer.ended > kLostAfter) {
        pacer.port->give_up_run();
        pacer.ended = now;
      }
      pacer.due = std::max(pacer.due + pacer.period, now);
    }
    next = std::min(next, pacer.due);
  }
  return next;
}

// A server that is there but is not to be this program's is told of once, and asked more and more seldom.
Status ClientEngine::dial_again() {
  // It may be one that never answers.
  Result<os::SharedMemory> memory = link_.dial(os::ThreadId{service_.load()}, [this] { return pace(os_.now()); });
  if (!memory && memory.error().kind() == ErrorKind::kEnvironment) {
    redial_after_ = kRedial;
    return memory.error();
  }
  // A server that was stopped and goes on has the region in which the nodes still are.
  const bool same = memory && memory->is(regions_.back().memory);
  Status done = !memory ? Status(memory.error()) : same ? Status(Done{}) : take_region(std::move(*memory));
  if (done) {
    done = join_again();
    if (!done && !same) {
      const std::lock_guard lock(members_mutex_);
      regions_.pop_back();
    }
  }
  if (!done) {
    link_.hang_up();
    redial_after_ = std::clamp(2 * redial_after_, kRedial, kLongestRedial);
    const std::string why = done.error().message();
    if (std::exchange(refusal_, why) != why) notice("server: there is one, but nodes stay by themselves: " + why);
    return done;
  }
  refusal_.clear();
  redial_after_ = kRedial;
  pulse_.begin(os_.now(), regions_.back().region.pulse().beats.load(std::memory_order_acquire));
  served_.store(true, std::memory_order_release);
  return Done{};
}

// All or none: a server that refuses one of the nodes gets none of them, and nothing is written into its region.
Status ClientEngine::join_again() {
  const std::lock_guard lock(members_mutex_);
  for (Member& member : members_) {
    // As it was asked for while there was no server; what a server did to it is not.
    if (auto before = before_serving(member.thread)) member.before = std::move(before);
    if (Status joined = ask_to_join(member); !joined) return joined;
  }
  move_nodes_to(regions_.back().region);
  return Done{};
}

// Also those that nobody runs yet. A trigger that waits there already is taken.
void ClientEngine::move_nodes_to(const Region& region) {
  for (std::size_t index = 0; index < app_->graph.nodes().size(); ++index) {
    NodePort* const port = wiring_->port(NodeId(index));
    const bool runs = std::any_of(members_.begin(), members_.end(),
                                  [&](const Member& member) { return member.node == NodeId(index); });
    if (port == nullptr || port->uses(region)) continue;
    runs ? port->move_to(region) : port->settle_in(region);
  }
}

// A node is in the one before until its next run.
void ClientEngine::forget_old_regions() {
  const std::lock_guard lock(members_mutex_);
  for (const Member& member : members_) wiring_->port(member.node)->look_again();
  regions_.remove_if([&](const Served& old) {
    return &old != &regions_.back() && std::none_of(members_.begin(), members_.end(), [&](const Member& member) {
      return wiring_->port(member.node)->uses(old.region);
    });
  });
}

void ClientEngine::notice(const std::string& text) const {
  if (options_.on_notice) options_.on_notice(text);
}

}  // namespace ctn::runtime
