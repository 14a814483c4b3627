#include "runtime/registered_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace ctn::runtime {

RegisteredNodes::RegisteredNodes(const graph::App& app, os::Os& os, const Region& region, Links& links,
                                 driver::Notices& notices)
    : app_(app),
      os_(os),
      region_(region),
      links_(links),
      notices_(notices),
      presence_(app.graph.nodes().size(), Presence::kAway),
      left_(app.graph.subchains().size(), false) {}

void RegisteredNodes::open(Enforcer& enforcer, Placement placement) {
  const std::lock_guard lock(mutex_);
  enforcer_ = &enforcer;
  placement_ = std::move(placement);
  cpus_ = placement_.cpus;
  unscheduled_level_.store(placement_.unscheduled, std::memory_order_release);
}

void RegisteredNodes::raise_unscheduled(os::Level level) {
  std::vector<Presence> presence;
  {
    const std::lock_guard lock(mutex_);
    if (level <= unscheduled_level_.load(std::memory_order_relaxed)) return;
    unscheduled_level_.store(level, std::memory_order_release);
    presence = presence_;
  }
  for (std::size_t index = 0; index < presence.size(); ++index) {
    if (presence[index] != Presence::kRegistered || !app_.graph.nodes()[index].unscheduled) continue;
    // Raised inside the visit: a thread removed meanwhile is restored only after it.
    links_[index]->for_each_thread([&](os::ThreadId thread) { enforcer_->raise(thread, level); });
  }
}

void RegisteredNodes::place_on(const os::CpuSet& cpus) {
  const std::lock_guard lock(mutex_);
  cpus_ = cpus;
}

// Of its threads when they are placed. Nobody watches the runs of a subchain yet that misses a node, so those of
// scheduled nodes are ordinary until the controller that holds the subchain sets their level.
os::Level RegisteredNodes::level_of(NodeId node) const {
  if (!app_.graph.node(node).unscheduled) return os::Level::kOrdinary;
  return unscheduled_level_.load(std::memory_order_acquire);
}

// Between the moment that a thread was placed and that it is known to have joined, unscheduled nodes may have been
// raised.
void RegisteredNodes::raise_if_changed(NodeId node, os::Level placed_at) {
  const os::Level level = level_of(node);
  if (level == placed_at) return;
  links_[node.index()]->for_each_thread([&](os::ThreadId thread) { enforcer_->raise(thread, level); });
}

void RegisteredNodes::set(NodeId node, Presence presence) {
  const std::lock_guard lock(mutex_);
  presence_[node.index()] = presence;
}

bool RegisteredNodes::has_all(const graph::Subchain& subchain) const {
  return std::all_of(subchain.nodes.begin(), subchain.nodes.end(),
                     [&](NodeId node) { return presence_[node.index()] == Presence::kRegistered; });
}

bool RegisteredNodes::has_all_of(const graph::Subchain& subchain) const {
  const std::lock_guard lock(mutex_);
  return has_all(subchain);
}

std::vector<NodeId> RegisteredNodes::missing_of(const graph::Subchain& subchain) const {
  const std::lock_guard lock(mutex_);
  std::vector<NodeId> missing;
  std::copy_if(subchain.nodes.begin(), subchain.nodes.end(), std::back_inserter(missing),
               [&](NodeId node) { return presence_[node.index()] != Presence::kRegistered; });
  return missing;
}

// Else both nodes' controllers would set its level, and it would stay raised when one of the nodes gives it up.
Status RegisteredNodes::check_free(NodeId node, os::ThreadId thread) const {
  for (const std::unique_ptr<NodeLink>& link : links_) {
    if (!link || link->node() == node || !link->has(thread)) continue;
    return Error::caller(fmt::format("thread {} works for node {}", static_cast<std::int32_t>(thread),
                                     app_.graph.node(link->node()).name),
                         "have each node's runs in threads of its own");
  }
  return Done{};
}

Status RegisteredNodes::join(NodeId node, os::ProcessId process, os::ThreadId thread) {
  const std::string& name = app_.graph.node(node).name;
  if (!links_[node.index()]) {
    return Error::caller(fmt::format("node {} is external", name), "join as another, or drop 'external: true'");
  }
  if (Status is_free = check_free(node, thread); !is_free) return is_free;
  {
    const std::lock_guard lock(mutex_);
    if (presence_[node.index()] != Presence::kAway) {
      return Error::caller(fmt::format("node {} is there already", name), "stop the program that runs it, or this one");
    }
    presence_[node.index()] = Presence::kJoining;
  }
  // Before any controller knows these threads: what is set here is read back, and nothing may change it in between.
  const os::Level placed_at = level_of(node);
  std::vector<os::ThreadId> placed;
  for (std::vector<os::ThreadId> next{thread}; !next.empty(); next = join_with(node, placed)) {
    for (const os::ThreadId each : next) {
      placed.push_back(each);
      const Status done = place(node, process, each);
      if (done) continue;
      for (const os::ThreadId other : placed) enforcer_->restore(other);
      set(node, Presence::kAway);
      return done;
    }
  }
  raise_if_changed(node, placed_at);
  return Done{};
}

// The node has joined if all of its threads have been placed, the first of them its own; else which have not. Threads
// are named under the same lock while it has not joined, so that none is missed.
std::vector<os::ThreadId> RegisteredNodes::join_with(NodeId node, const std::vector<os::ThreadId>& placed) {
  const std::lock_guard lock(mutex_);
  std::vector<os::ThreadId> missing = links_[node.index()]->threads();
  std::erase_if(missing,
                [&](os::ThreadId each) { return std::find(placed.begin(), placed.end(), each) != placed.end(); });
  if (!missing.empty()) return missing;
  links_[node.index()]->add_thread(placed.front());
  presence_[node.index()] = Presence::kRegistered;
  joined_.push_back(node);
  return {};
}

Status RegisteredNodes::add_thread(NodeId node, os::ProcessId process, os::ThreadId thread) {
  NodeLink& link = *links_[node.index()];
  if (link.has(thread)) return Done{};
  if (Status is_free = check_free(node, thread); !is_free) return is_free;
  const Error no_room =
      Error::caller(fmt::format("node {} has {} threads already", app_.graph.node(node).name, NodeCell::kMaxThreads),
                    "use fewer threads");
  // Before any controller knows it; where the node has not joined, it is placed when the node joins.
  std::optional<os::Level> placed_at;
  Added added = add_if_placed(node, thread, false);
  if (added == Added::kNotPlaced) {
    placed_at = level_of(node);
    if (!link.announce_thread(thread)) return no_room;
    if (Status placed = place(node, process, thread); !placed) {
      enforcer_->restore(thread);
      link.withdraw_thread(thread);
      return placed;
    }
    added = add_if_placed(node, thread, true);
  }
  if (placed_at && added != Added::kToJoined) enforcer_->restore(thread);  // the node has left meanwhile
  if (added == Added::kNoRoom) return no_room;
  if (added == Added::kToJoined) {
    raise_if_changed(node, *placed_at);
    wake_holder(node);
  }
  return Done{};
}

RegisteredNodes::Added RegisteredNodes::add_if_placed(NodeId node, os::ThreadId thread, bool placed) {
  const std::lock_guard lock(mutex_);
  const bool joined = presence_[node.index()] == Presence::kRegistered;
  if (joined && !placed) return Added::kNotPlaced;
  if (!links_[node.index()]->add_thread(thread)) return Added::kNoRoom;
  return joined ? Added::kToJoined : Added::kForLater;
}

void RegisteredNodes::remove_thread(NodeId node, os::ThreadId thread) {
  links_[node.index()]->remove_thread(thread, [this](os::ThreadId removed) { enforcer_->restore(removed); });
}

// On all CPUs, until the controller that holds the subchain sets its level and CPUs. That scheduled nodes can be raised
// is found out here all the same, before the plan counts on it.
Status RegisteredNodes::place(NodeId node, os::ProcessId process, os::ThreadId thread) {
  os::CpuSet cpus;
  {
    const std::lock_guard lock(mutex_);
    cpus = cpus_;
  }
  Status placed = enforcer_->apply(thread, level_of(node), cpus, process);
  if (placed && !app_.graph.node(node).unscheduled) enforcer_->try_level(thread, placement_.scheduled, process);
  return placed;
}

void RegisteredNodes::forget_ended_threads() {
  std::vector<os::ThreadId> ended;
  for (const std::unique_ptr<NodeLink>& link : links_) {
    if (!link) continue;
    ended.clear();
    link->for_each_clock([&](os::ThreadId thread, os::CpuClock& clock) {
      if (!clock.now()) ended.push_back(thread);
    });
    for (const os::ThreadId thread : ended) remove_thread(link->node(), thread);
  }
}

void RegisteredNodes::lower(NodeId node) {
  links_[node.index()]->for_each_thread(
      [&](os::ThreadId thread) { enforcer_->set_level_now(thread, os::Level::kOrdinary); });
}

void RegisteredNodes::raise_again(NodeId node) {
  const os::Level level = level_of(node);
  links_[node.index()]->for_each_thread([&](os::ThreadId thread) { enforcer_->set_level_now(thread, level); });
}

void RegisteredNodes::wake_holder(NodeId node) {
  const std::optional<SubchainId> subchain = app_.graph.node(node).subchain;
  if (!subchain) return;
  const std::uint32_t holder = region_.signal(*subchain).holder.load(std::memory_order_seq_cst);
  if (holder != 0 && holder <= region_.controller_cells()) region_.controller_cell(holder - 1).wake(os_);
}

bool RegisteredNodes::leave(NodeId node, const std::string& why) {
  NodeLink* const link = links_[node.index()].get();
  bool expected = false;
  {
    const std::lock_guard lock(mutex_);
    if (presence_[node.index()] != Presence::kRegistered) return false;
    presence_[node.index()] = Presence::kLeaving;
    expected = leaving_is_expected_;
    if (const auto subchain = app_.graph.node(node).subchain) left_[subchain->index()] = true;
  }
  link->remove_all_threads([this](os::ThreadId removed) { enforcer_->restore(removed); });
  set(node, Presence::kAway);
  if (!expected) {
    notices_.add({os_.now(), "node-left",
                  fmt::format("node {} is gone: {}{}", app_.graph.node(node).name, why, broken_chains(node))});
  }
  return true;
}

void RegisteredNodes::expect_all_to_leave() {
  const std::lock_guard lock(mutex_);
  leaving_is_expected_ = true;
}

std::string RegisteredNodes::broken_chains(NodeId node) const {
  std::string chains;
  for (const graph::Term& term : app_.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    if (std::find(term.path.begin(), term.path.end(), node) == term.path.end()) continue;
    chains += (chains.empty() ? "; broken until it is back: " : ", ") + app_.graph.path_name(term.path);
  }
  return chains;
}

RegisteredNodes::Change RegisteredNodes::settle(const std::vector<bool>& paced) {
  Change change;
  const std::lock_guard lock(mutex_);
  for (std::size_t index = 0; index < paced.size(); ++index) {
    const bool all_registered = has_all(app_.graph.subchains()[index]);
    if (paced[index] && (!all_registered || left_[index])) change.left.emplace_back(index);
    if (!paced[index] && all_registered) change.back.emplace_back(index);
    left_[index] = false;
  }
  return change;
}

std::vector<NodeId> RegisteredNodes::take_joined() {
  const std::lock_guard lock(mutex_);
  return std::exchange(joined_, {});
}

}  // namespace ctn::runtime
