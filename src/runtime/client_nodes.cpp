#include "runtime/client_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

namespace ctn::runtime {

void ClientNodes::add(NodeId node, os::ThreadId thread) {
  const auto state = state_.lock();
  if (const auto now = os_.save_scheduling(thread)) save(state->saved, *now);
  state->nodes.push_back({node, thread});
}

void ClientNodes::remove(NodeId node, os::ThreadId thread) {
  const auto state = state_.lock();
  const auto found = std::find_if(state->nodes.rbegin(), state->nodes.rend(), [&](const RegisteredNode& registered) {
    return registered.node == node && registered.thread == thread;
  });
  if (found == state->nodes.rend()) return;
  state->nodes.erase(std::next(found).base());
  state->saved.restore(thread);
}

bool ClientNodes::has(NodeId node) const {
  const auto state = state_.lock();
  return std::any_of(state->nodes.begin(), state->nodes.end(),
                     [&](const RegisteredNode& registered) { return registered.node == node; });
}

void ClientNodes::add_thread(NodeId node, os::ThreadId thread) {
  const auto state = state_.lock();
  forget_ended(*state);
  for (RegisteredNode& registered : state->nodes) {
    if (registered.node != node) continue;
    if (const auto now = os_.save_scheduling(thread)) save(state->saved, *now);
    std::erase(registered.others, thread);
    return registered.others.push_back(thread);
  }
}

void ClientNodes::remove_thread(NodeId node, os::ThreadId thread) {
  const auto state = state_.lock();
  for (RegisteredNode& registered : state->nodes) {
    if (registered.node == node) std::erase(registered.others, thread);
  }
}

Status ClientNodes::share(os::ThreadId thread) {
  const auto state = state_.lock();
  forget_ended(*state);
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return living.error();
  if (!std::binary_search(living->begin(), living->end(), thread)) {
    return Error::caller(fmt::format("thread {} is not one of this process", static_cast<std::int32_t>(thread)),
                         "name a thread of your own by what gettid() gives it");
  }
  if (std::find(state->shared.begin(), state->shared.end(), thread) != state->shared.end()) return Done{};
  if (const auto now = os_.save_scheduling(thread)) save(state->saved, *now);
  state->shared.push_back(thread);
  state->untold.push_back(thread);
  return Done{};
}

Status ClientNodes::tell_all_shared(Conversation& conversation, const Meanwhile& meanwhile) {
  {
    const auto state = state_.lock();
    state->untold = state->shared;
  }
  return tell_shared(conversation, meanwhile);
}

// One that has ended meanwhile is refused, and so are all by a server that does not know of shared threads: without
// them nodes run as well.
Status ClientNodes::tell_shared(Conversation& conversation, const Meanwhile& meanwhile) {
  std::vector<os::ThreadId> threads;
  threads.swap(state_.lock()->untold);
  for (const os::ThreadId thread : threads) {
    Status added = conversation.call(
        {.kind = Request::Kind::kAdd, .node = {}, .thread = static_cast<std::int32_t>(thread)}, meanwhile);
    if (!added && added.error().kind() != ErrorKind::kCaller) return added;
  }
  return Done{};
}

Status ClientNodes::join(const RegisteredNode& registered, const std::string& name, Conversation& conversation,
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

void ClientNodes::update_saved_scheduling() {
  const auto state = state_.lock();
  forget_ended(*state);
  const auto update = [&](os::ThreadId thread) {
    const Result<os::SavedScheduling> now = os_.save_scheduling(thread);
    // One that has the number of a thread that ended is not the node's.
    if (now && (state->saved.has(*now) || !state->saved.has(thread))) save(state->saved, *now);
  };
  for (const RegisteredNode& registered : state->nodes) {
    update(registered.thread);
    for (const os::ThreadId thread : registered.others) update(thread);
  }
  for (const os::ThreadId thread : state->shared) update(thread);
}

// Of the threads that were named. A node's own thread stays: a node that leaves says so.
void ClientNodes::forget_ended(State& state) const {
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return;
  const auto has_ended = [&](os::ThreadId thread) {
    if (!std::binary_search(living->begin(), living->end(), thread)) return true;
    const Result<os::SavedScheduling> now = os_.save_scheduling(thread);
    return now && state.saved.has(thread) && !state.saved.has(*now);
  };
  const auto is_own = [&](os::ThreadId thread) {
    return std::any_of(state.nodes.begin(), state.nodes.end(),
                       [&](const RegisteredNode& registered) { return registered.thread == thread; });
  };
  const auto forget = [&](std::vector<os::ThreadId>& threads) {
    const auto ended = std::partition(threads.begin(), threads.end(), std::not_fn(has_ended));
    std::for_each(ended, threads.end(), [&](os::ThreadId thread) {
      if (!is_own(thread)) state.saved.forget(thread);
    });
    threads.erase(ended, threads.end());
  };
  for (RegisteredNode& registered : state.nodes) forget(registered.others);
  forget(state.shared);
  std::erase_if(state.untold, [&](os::ThreadId thread) {
    return std::find(state.shared.begin(), state.shared.end(), thread) == state.shared.end();
  });
}

// What a thread had that a server has found and raised before the program named it only that server knows.
void ClientNodes::save(SavedThreads& saved, const os::SavedScheduling& now) const {
  if (!os_.is_raised(now)) {
    saved.save(now);
  } else if (!saved.has(now)) {
    saved.forget(now.thread);
  }
}

bool ClientNodes::raised_by_server(os::ThreadId thread) const {
  const Result<os::SavedScheduling> now = os_.save_scheduling(thread);
  return now && os_.is_raised(*now);
}

// Of the node: its own, and the threads that the region lists. `living`: of this process.
std::vector<os::ThreadId> ClientNodes::threads_of(const RegisteredNode& registered, const Region& region,
                                                  const std::vector<os::ThreadId>& living) {
  std::vector<os::ThreadId> threads{registered.thread};
  for (const std::atomic<std::int32_t>& listed : region.node(registered.node).thread) {
    threads.push_back(os::ThreadId{listed.load(std::memory_order_acquire)});
  }
  std::erase_if(threads,
                [&](os::ThreadId thread) { return !std::binary_search(living.begin(), living.end(), thread); });
  return threads;
}

bool ClientNodes::any_raised(const Region& region) const {
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return false;
  const auto raised = [this](os::ThreadId thread) { return raised_by_server(thread); };
  for (const RegisteredNode& registered : all()) {
    const std::vector<os::ThreadId> threads = threads_of(registered, region, *living);
    if (std::any_of(threads.begin(), threads.end(), raised)) return true;
  }
  const std::vector<os::ThreadId> named = shared();
  return std::any_of(named.begin(), named.end(), [&](os::ThreadId thread) {
    return std::binary_search(living->begin(), living->end(), thread) && raised(thread);
  });
}

void ClientNodes::restore_threads(const Region& region) {
  const Result<std::vector<os::ThreadId>> living = os_.threads(os_.current_process());
  if (!living) return;
  const auto state = state_.lock();
  forget_ended(*state);
  for (const RegisteredNode& registered : state->nodes) {
    for (const os::ThreadId thread : threads_of(registered, region, *living)) {
      if (state->saved.has(thread)) {
        state->saved.restore(thread);
      } else {
        state->saved.restore_unknown(thread, raised_by_server(thread), registered.thread);
      }
    }
  }
  // A server may have handed them to a node that did not join in the end, so that nobody looks at its list.
  for (const os::ThreadId thread : state->shared) {
    if (state->saved.has(thread)) {
      state->saved.restore(thread);
    } else if (raised_by_server(thread)) {
      const os::ThreadId like = state->nodes.empty() ? thread : state->nodes.front().thread;
      state->saved.restore_unknown(thread, true, like);
    }
  }
}

}  // namespace ctn::runtime
