#include "runtime/client_members.h"

#include <algorithm>
#include <utility>

namespace ctn::runtime {

void ClientMembers::add(NodeId node, os::ThreadId thread) {
  RegisteredNode member{node, thread, {}, scheduling_before(thread)};
  members_.lock()->push_back(std::move(member));
}

void ClientMembers::remove(NodeId node, os::ThreadId thread) {
  const auto members = members_.lock();
  const auto found = std::find_if(members->rbegin(), members->rend(), [&](const RegisteredNode& member) {
    return member.node == node && member.thread == thread;
  });
  if (found != members->rend()) members->erase(std::next(found).base());
}

bool ClientMembers::has(NodeId node) const {
  const auto members = members_.lock();
  return std::any_of(members->begin(), members->end(),
                     [&](const RegisteredNode& member) { return member.node == node; });
}

void ClientMembers::add_thread(NodeId node, os::ThreadId thread) {
  const auto members = members_.lock();
  for (RegisteredNode& member : *members) {
    if (member.node == node) return member.others.push_back(thread);
  }
}

void ClientMembers::remove_thread(NodeId node, os::ThreadId thread) {
  const auto members = members_.lock();
  for (RegisteredNode& member : *members) {
    if (member.node == node) std::erase(member.others, thread);
  }
}

Status ClientMembers::join(const RegisteredNode& registered, const std::string& name, Conversation& conversation,
                           const Meanwhile& meanwhile) {
  const auto ask = [&](Request::Kind kind, os::ThreadId thread) {
    return conversation.call({.kind = kind, .node = name, .thread = static_cast<std::int32_t>(thread)}, meanwhile);
  };
  if (Status joined = ask(Request::Kind::kJoin, registered.thread); !joined) return joined;
  for (const os::ThreadId other : registered.others) {
    Status added = ask(Request::Kind::kAdd, other);
    if (!added && added.error().kind() != ErrorKind::kCaller) return added;
    if (!added) remove_thread(registered.node, other);  // it has ended meanwhile
  }
  return Done{};
}

void ClientMembers::update_saved_scheduling() {
  const auto members = members_.lock();
  for (RegisteredNode& member : *members) {
    auto before = scheduling_before(member.thread);
    const bool reused = before && member.before && !before->same_thread(*member.before);
    if (before && !reused) member.before = std::move(before);
  }
}

// A thread that a server has found and raised before the program named it: only that server knows what it had.
std::optional<os::SavedScheduling> ClientMembers::scheduling_before(os::ThreadId thread) const {
  const Result<os::SavedScheduling> saved = os_.save_scheduling(thread);
  if (!saved || raised_by_server(thread)) return std::nullopt;
  return *saved;
}

// By what a raised thread looks like; real-time threads of the program's own seldom have the flag.
bool ClientMembers::raised_by_server(os::ThreadId thread) const {
  const Result<os::Level> level = os_.level(thread);
  if (!level || *level == os::Level::kOrdinary) return false;
  const Result<os::SavedScheduling> found = os_.save_scheduling(thread);
  return found && found->reset_on_fork;
}

bool ClientMembers::any_raised(const Region& region) const {
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return false;
  const auto raised = [&](os::ThreadId thread) {
    return std::binary_search(living->begin(), living->end(), thread) && raised_by_server(thread);
  };
  for (const RegisteredNode& member : all()) {
    if (raised(member.thread)) return true;
    for (const std::atomic<std::int32_t>& listed : region.node(member.node).thread) {
      if (raised(os::ThreadId{listed.load(std::memory_order_acquire)})) return true;
    }
  }
  return false;
}

void ClientMembers::restore_threads(const Region& region) const {
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return;
  for (const RegisteredNode& member : all()) restore_threads(member, *living, region);
}

void ClientMembers::restore_threads(const RegisteredNode& member, const std::vector<os::ThreadId>& living,
                                    const Region& region) const {
  const auto alive = [&](os::ThreadId thread) { return std::binary_search(living.begin(), living.end(), thread); };
  for (const std::atomic<std::int32_t>& listed : region.node(member.node).thread) {
    const os::ThreadId thread{listed.load(std::memory_order_acquire)};
    if (thread == member.thread || !alive(thread)) continue;
    if (raised_by_server(thread)) static_cast<void>(os_.set_level(thread, os::Level::kOrdinary));
    if (member.before) static_cast<void>(os_.set_affinity(thread, member.before->affinity));
  }
  if (!alive(member.thread)) return;
  if (member.before) {
    static_cast<void>(os_.restore_scheduling(*member.before));
  } else if (raised_by_server(member.thread)) {
    static_cast<void>(os_.set_level(member.thread, os::Level::kOrdinary));
  }
}

}  // namespace ctn::runtime
