// How nodes come and go.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/scheduler.h"

namespace ctn::runtime {

bool Scheduler::has(NodeId node) const {
  const std::lock_guard lock(mutex_);
  return members_[node.index()];
}

// Under the lock, or before the housekeeper's thread runs.
bool Scheduler::complete(const graph::Subchain& subchain) const {
  return std::all_of(subchain.nodes.begin(), subchain.nodes.end(), [&](NodeId node) { return members_[node.index()]; });
}

Status Scheduler::join(NodeId node, os::ProcessId process, os::ThreadId thread) {
  const std::string& name = app_.graph.node(node).name;
  if (!links_[node.index()]) {
    return Error::caller(fmt::format("node {} is external", name), "join as another, or drop 'external: true'");
  }
  if (has(node)) {
    return Error::caller(fmt::format("node {} is there already", name), "stop the program that runs it, or this one");
  }
  // Before any dispatcher knows of them: what is set is read back, and nobody else may set it in between.
  std::vector<os::ThreadId> threads = links_[node.index()]->threads();
  threads.push_back(thread);
  for (const os::ThreadId each : threads) {
    const Status placed = place(node, process, each);
    if (placed) continue;
    for (const os::ThreadId other : threads) enforcer_->release(other);
    return placed;
  }
  housekeeper_->begins_anew(node);
  {
    const std::lock_guard lock(mutex_);
    links_[node.index()]->add_thread(thread);
    members_[node.index()] = true;
  }
  housekeeper_->nudge();
  return Done{};
}

Status Scheduler::add_thread(NodeId node, os::ProcessId process, os::ThreadId thread) {
  NodeLink& link = *links_[node.index()];
  if (link.has(thread)) return Done{};
  const Error no_room =
      Error::caller(fmt::format("node {} has {} threads already", app_.graph.node(node).name, NodeCell::kMaxThreads),
                    "use fewer threads");
  if (link.threads().size() >= NodeCell::kMaxThreads) return no_room;
  const bool joined = has(node);  // else it is placed when the node joins
  if (joined) {
    if (Status placed = place(node, process, thread); !placed) return placed;
  }
  if (!link.add_thread(thread)) {
    if (joined) enforcer_->release(thread);
    return no_room;
  }
  if (joined) tell_holder(node);
  return Done{};
}

void Scheduler::remove_thread(NodeId node, os::ThreadId thread) {
  links_[node.index()]->remove_thread(thread);
  enforcer_->release(thread);
}

// Where its subchain is, or is to be: who shares a core waits in the background for its dispatcher, and who has joined
// a subchain that is under way is given its place by whoever holds it.
Status Scheduler::place(NodeId node, os::ProcessId process, os::ThreadId thread) {
  os::Level level = os::Level::kOrdinary;
  if (options_.policy->raises()) {
    level = app_.graph.node(node).unscheduled ? decision_.unscheduled_level : os::Level::kBackground;
  }
  return enforcer_->apply(thread, level, cpus_, process);
}

void Scheduler::tell_holder(NodeId node) {
  const std::optional<SubchainId> subchain = app_.graph.node(node).subchain;
  if (!subchain) return;
  const std::uint32_t holder = region_.signal(*subchain).listener.load(std::memory_order_seq_cst);
  if (holder != 0 && holder <= region_.attentions()) region_.attention(holder - 1).nudge(os_);
}

void Scheduler::leave(NodeId node, const std::string& why) {
  NodeLink* const link = links_[node.index()].get();
  bool expected = false;
  {
    const std::lock_guard lock(mutex_);
    if (!members_[node.index()]) return;
    members_[node.index()] = false;
    expected = released_;
    if (const auto subchain = app_.graph.node(node).subchain) broken_[subchain->index()] = true;
  }
  const std::vector<os::ThreadId> threads = link->threads();
  link->remove_all_threads();
  for (const os::ThreadId thread : threads) enforcer_->release(thread);
  if (expected) return;
  housekeeper_->nudge();
  housekeeper_->notice("node-left",
                       fmt::format("node {} is gone: {}{}", app_.graph.node(node).name, why, broken_chains(node)));
}

std::string Scheduler::broken_chains(NodeId node) const {
  std::string chains;
  for (const graph::Term& term : app_.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    if (std::find(term.path.begin(), term.path.end(), node) == term.path.end()) continue;
    chains += (chains.empty() ? "; broken until it is back: " : ", ") + app_.graph.path_name(term.path);
  }
  return chains;
}

void Scheduler::tend_guard() {
  const Result<int> replaced = enforcer_->tend_guard();
  if (!replaced) {
    if (!std::exchange(guard_missing_, true)) notice("guard", replaced.error().message());
    return;
  }
  guard_missing_ = false;
  if (std::exchange(guards_replaced_, *replaced) != *replaced) {
    notice("guard",
           "somebody ended the guardian, which gives threads their scheduling back if this process is killed; "
           "there is another");
  }
}

// In the housekeeper's thread.
void Scheduler::settle_members() {
  std::vector<SubchainId> left;
  std::vector<SubchainId> back;
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t index = 0; index < in_force_.size(); ++index) {
      const bool whole = complete(app_.graph.subchains()[index]);
      if (in_force_[index] && (!whole || broken_[index])) left.emplace_back(index);
      if (!in_force_[index] && whole) back.emplace_back(index);
      broken_[index] = false;
    }
  }
  for (const SubchainId id : left) in_force_[id.index()] = false;
  std::erase_if(back, [&](SubchainId id) { return !clear_for_return(id); });
  for (const SubchainId id : back) in_force_[id.index()] = true;
  if (!left.empty() || !back.empty()) publish(assignment());
  for (const SubchainId id : back) {
    housekeeper_->notice("subchain", fmt::format("subchain {} is whole: it is paced", app_.graph.subchain(id).name));
  }
}

// False: whoever held it has not let go yet. What was under way when it was left counts as ended. While this process
// was stopped its nodes may have paced themselves, and are at most one trigger ahead of what has ended: the next number
// is beyond that, since a node does not see a trigger of the number that it is at.
bool Scheduler::clear_for_return(SubchainId subchain) {
  std::optional<dispatch::RunState> state = controls_->handovers[subchain.index()].take();
  if (!state) return false;
  constexpr std::uint64_t kAhead = 8;
  constexpr std::uint64_t kMostAlone = 1U << 30;  // more is what nobody of ours has written
  const std::uint64_t ended = region_.signal(subchain).completed.load(std::memory_order_seq_cst);
  if (ended > state->sent && ended - state->sent < kMostAlone) state->sent = ended;
  state->sent += kAhead;
  state->completed = state->sent;
  state->hanging = false;
  region_.signal(subchain).completed.store(state->sent, std::memory_order_seq_cst);
  controls_->handovers[subchain.index()].put(*state);
  return true;
}

}  // namespace ctn::runtime
