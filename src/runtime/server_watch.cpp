#include "runtime/server_watch.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace ctn::runtime {

ServerWatch::ServerWatch(Program program, ServedRegions regions)
    : program_(std::move(program)), regions_(std::move(regions)) {
  begin_heartbeat();
  set(State::kServed);
}

void ServerWatch::run() {
  TimePoint wake = program_.os.now();
  while (!program_.stopping()) {
    const bool gone = program_.link.wait(wake);
    wake = step(program_.os.now(), gone);
  }
}

TimePoint ServerWatch::step(TimePoint now, bool gone) {
  if (gone || (state_ == State::kServed && !server_alive(now))) lose_server(now, gone);
  if (state_ != State::kServed) return run_without_server(now);
  regions_.drop_old(program_.wiring, running());
  if (program_.registered.has_untold()) tell_shared();
  tell_misuses();
  return heartbeat_.next_check();
}

void ServerWatch::tell_misuses() {
  for (record::Notice& misuse : program_.wiring.take_misuses(program_.os.now())) {
    program_.notices.add(std::move(misuse));
  }
}

// Where the server does not answer, the link says so at the next step, and the next server is told of all.
void ServerWatch::tell_shared() {
  const std::unique_ptr<Conversation> conversation = program_.link.converse();
  const Meanwhile meanwhile = [this]() -> std::optional<TimePoint> {
    if (program_.stopping() || !server_alive(program_.os.now())) return std::nullopt;
    return heartbeat_.next_check();
  };
  static_cast<void>(program_.registered.tell_shared(*conversation, meanwhile));
}

void ServerWatch::leave() {
  tell_misuses();
  bool all_left = true;
  // One that does nothing is not asked.
  if (state_ != State::kServed) program_.link.hang_up();
  {
    const std::unique_ptr<Conversation> conversation = program_.link.converse();
    for (const NodeId node : running()) {
      const std::string& name = program_.app.graph.node(node).name;
      all_left = conversation->call({.kind = Request::Kind::kLeave, .node = name}).ok() && all_left;
    }
  }
  if (!all_left) program_.registered.restore_threads(regions_.newest());
  program_.link.hang_up();
  set(State::kAway);
  for (const NodeId node : running()) program_.wiring.port(node)->stop();
}

void ServerWatch::set(State state) {
  state_ = state;
  program_.served.store(state == State::kServed, std::memory_order_release);
}

void ServerWatch::begin_heartbeat() {
  heartbeat_.begin(program_.os.now(), regions_.newest().heartbeat().beats.load(std::memory_order_acquire));
}

bool ServerWatch::server_alive(TimePoint now) {
  const Heartbeat& heartbeat = regions_.newest().heartbeat();
  return heartbeat_.alive(now, heartbeat.beats.load(std::memory_order_acquire),
                          Nanos{heartbeat.max_heartbeat_gap.load(std::memory_order_acquire)});
}

void ServerWatch::lose_server(TimePoint now, bool gone) {
  const bool was_served = state_ == State::kServed;
  set(gone ? State::kAway : State::kSilent);
  gone ? redial_.at_once(now) : redial_.not_now();
  if (was_served) {
    restore_threads(now);
    begin_pacing(now);
  }
  const std::string rates = "; nodes go on at the rates that were planned last";
  notice((gone ? "it is gone" : "it does nothing any more") + (was_served ? rates : ""));
}

void ServerWatch::begin_pacing(TimePoint now) {
  const graph::Graph& graph = regions_.newest_app().graph;
  std::vector<UnservedPacer::Head> heads;
  for (const NodeId node : running()) {
    const std::optional<SubchainId> id = graph.node(node).subchain;
    if (!id || graph.subchain(*id).nodes.front() != node) continue;
    heads.push_back({program_.wiring.port(node), period_without_server(graph, *id, regions_.newest())});
  }
  pacer_.begin(now, heads);
}

void ServerWatch::restore_threads(TimePoint now) {
  program_.registered.restore_threads(regions_.newest());
  find_raised_ = now + kRaisedSearchPeriod;
  wait_until_ = now + kLongestCall;
}

TimePoint ServerWatch::run_without_server(TimePoint now) {
  const TimePoint wake = pace_and_restore(now);
  if (state_ == State::kSilent) {
    if (!server_alive(now)) return std::min(wake, heartbeat_.next_check());
    program_.link.hang_up();
    set(State::kAway);
    redial_.at_once(now);
  }
  if (now >= redial_.due()) reconnect();
  return state_ == State::kServed ? heartbeat_.next_check() : std::min(wake, redial_.due());
}

// Triggers nodes that are due, and restores threads that a server has raised all the same. Returns when it is to be
// called again.
TimePoint ServerWatch::pace_and_restore(TimePoint now) {
  const TimePoint wake = pacer_.pace_heads(now);
  if (now >= wait_until_) return wake;
  if (now >= find_raised_) {
    find_raised_ = now + kRaisedSearchPeriod;
    const Region& region = regions_.newest();
    if (program_.registered.any_raised(region)) program_.registered.restore_threads(region);
  }
  return std::min(wake, find_raised_);
}

void ServerWatch::reconnect() {
  const Dialled dialled = dial_and_join();
  if (dialled.done) {
    refusal_.clear();
    redial_.not_now();
    set(State::kServed);
    return notice("there is one again, and it schedules the nodes");
  }
  program_.link.hang_up();
  const TimePoint now = program_.os.now();
  if (dialled.may_have_raised) restore_threads(now);
  if (dialled.done.error().kind() == ErrorKind::kEnvironment && (!dialled.answered || dialled.known)) {
    redial_.unanswered(now);
  } else {
    redial_.refused(now, dialled.known);
  }
  const std::string why = dialled.done.error().message();
  if (dialled.answered && std::exchange(refusal_, why) != why) {
    notice("there is one, but nodes go on without it: " + why);
  }
}

ServerWatch::Dialled ServerWatch::dial_and_join() {
  const std::unique_ptr<Conversation> conversation = program_.link.converse();
  // It may be one that never answers.
  const Meanwhile meanwhile = [this]() -> std::optional<TimePoint> {
    if (program_.stopping()) return std::nullopt;
    return pace_and_restore(program_.os.now());
  };
  Result<os::SharedMemory> memory = conversation->dial(program_.os.current_thread(), meanwhile);
  if (!memory) return {.done = memory.error(), .answered = memory.error().kind() == ErrorKind::kCaller};
  // A server that was stopped and goes on has the region in which the nodes still are.
  const bool known = regions_.is_newest(*memory);
  return {.done = take_over(*conversation, std::move(*memory), known),
          .answered = true,
          .known = known,
          .may_have_raised = true};
}

Status ServerWatch::take_over(Conversation& conversation, os::SharedMemory memory, bool known) {
  if (!known) {
    if (Status added = regions_.add(std::move(memory)); !added) return added;
  }
  begin_heartbeat();
  Status joined = rejoin(conversation);
  if (!joined && !known) regions_.drop_newest();
  return joined;
}

// All or none: a server that refuses one of the nodes gets none of them, and nothing is written into its region.
Status ServerWatch::rejoin(Conversation& conversation) {
  // Nodes are run until they are taken over, and a server that is stopped once more is not waited for.
  const Meanwhile meanwhile = [this]() -> std::optional<TimePoint> {
    const TimePoint now = program_.os.now();
    if (!server_alive(now)) return std::nullopt;
    return std::min(pacer_.pace_heads(now), heartbeat_.next_check());
  };
  program_.registered.update_saved_scheduling();
  for (const ClientNodes::RegisteredNode& registered : program_.registered.all()) {
    const std::string& name = program_.app.graph.node(registered.node).name;
    if (Status joined = program_.registered.join(registered, name, conversation, meanwhile); !joined) return joined;
  }
  if (Status told = program_.registered.tell_all_shared(conversation, meanwhile); !told) return told;
  regions_.move_nodes(program_.wiring, running());
  return Done{};
}

std::vector<NodeId> ServerWatch::running() const {
  std::vector<NodeId> nodes;
  for (const ClientNodes::RegisteredNode& registered : program_.registered.all()) nodes.push_back(registered.node);
  return nodes;
}

}  // namespace ctn::runtime
