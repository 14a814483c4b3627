#include "runtime/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/text.h"

namespace ctn::runtime {
namespace {

Status same_version(const Request& request) {
  if (request.version == kProtocolVersion) return Done{};
  return Error::caller(
      fmt::format("the program speaks version {}, the server version {}", request.version, kProtocolVersion),
      "let both be of one version");
}

bool is_control(Request::Kind kind) {
  return kind == Request::Kind::kApp || kind == Request::Kind::kChange || kind == Request::Kind::kStatus ||
         kind == Request::Kind::kFlight;
}

// To the answer of a request that was granted.
Registry::Attached attached_to(Request::Kind kind) {
  switch (kind) {
    case Request::Kind::kHello:
      return Registry::Attached::kRegion;
    case Request::Kind::kStatus:
      return Registry::Attached::kStatus;
    case Request::Kind::kFlight:
      return Registry::Attached::kFlight;
    default:
      return Registry::Attached::kNone;
  }
}

bool contains(const std::vector<os::ThreadId>& threads, os::ThreadId thread) {
  return std::find(threads.begin(), threads.end(), thread) != threads.end();
}

}  // namespace

Registry::ProgramId Registry::enter(os::ProcessId process, bool may_control) {
  Program& program = programs_[++next_];
  program.process = process;
  program.may_control = may_control;
  return next_;
}

Registry::Answer Registry::handle(ProgramId id, os::ProcessId sender, std::string_view message) {
  Program& program = programs_.at(id);
  if (sender != program.process) {
    return {to_text(Status(Error::caller("another process than the one that connected wrote this",
                                         "connect in the process that runs the node")))};
  }
  const Result<Request> request = parse_request(message);
  if (!request) return {to_text(Status(request.error()))};
  const Status done = carry_out(program, *request);
  if (done && request->kind == Request::Kind::kApp) return {app_reply(scheduler_.app().name)};
  return {to_text(done), done ? attached_to(request->kind) : Attached::kNone};
}

Status Registry::control(const Program& program, const Request& request) {
  if (Status same = same_version(request); !same) return same;
  if (!program.may_control) {
    return Error::caller("only root and the user that the server runs as may control it", "run this as one of them");
  }
  return request.kind == Request::Kind::kChange ? scheduler_.change(request.changes) : Status(Done{});
}

Status Registry::carry_out(Program& program, const Request& request) {
  if (request.kind == Request::Kind::kHello) return hello(program, request);
  if (is_control(request.kind)) return control(program, request);
  if (!program.service) return Error::caller("nothing was said before hello", "say hello first");
  if (request.kind == Request::Kind::kAdd && request.node.empty()) return share(program, os::ThreadId{request.thread});
  const std::optional<NodeId> node = scheduler_.app().graph.find_node(request.node);
  if (!node) {
    return Error::caller(fmt::format("app {} has no node '{}'", scheduler_.app().name, request.node.substr(0, 100)),
                         "use a name from its nodes section");
  }
  const os::ThreadId thread{request.thread};
  if (request.kind == Request::Kind::kJoin) {
    const Result<Threads> living = threads_with(program, thread);
    if (!living) return living.error();
    unshare(program, thread);
    // Before the thread is placed as this node's: it may be among the threads that were taken for another's.
    if (!program.nodes.contains(*node)) give_up_found(program.process);
    if (Status joined = scheduler_.join(*node, program.process, thread); !joined) return joined;
    program.nodes.insert(*node);
    program.joined_since_search = true;
    hand_over_shared(program);
    place_shared(program, *living);
    return Done{};
  }
  if (!program.nodes.contains(*node)) {
    return Error::caller(fmt::format("this program does not run node {}", request.node), "join it first");
  }
  if (request.kind == Request::Kind::kLeave) {
    program.nodes.erase(*node);
    scheduler_.leave(*node, "its program has ended it");
    hand_over_shared(program);
    place_shared(program);
    return Done{};
  }
  if (const Result<Threads> living = threads_with(program, thread); !living) return living.error();
  unshare(program, thread);
  std::erase(program.found, thread);  // it has a name now
  return scheduler_.add_thread(*node, program.process, thread);
}

Status Registry::hello(Program& program, const Request& request) {
  if (Status same = same_version(request); !same) return same;
  if (program.service) return Error::caller("hello was said before", "say it once");
  const os::ThreadId thread{request.thread};
  if (const Result<Threads> living = threads_with(program, thread); !living) return living.error();
  program.service = thread;
  scheduler_.watch_cpus_of(thread);
  return Done{};
}

// All threads of the program, if this is one.
Result<Registry::Threads> Registry::threads_with(const Program& program, os::ThreadId thread) const {
  Result<Threads> living = threads_.threads(program.process);
  if (living && std::binary_search(living->begin(), living->end(), thread)) return living;
  return Error::caller(fmt::format("thread {} is not one of process {}", static_cast<std::int32_t>(thread),
                                   static_cast<std::int32_t>(program.process)),
                       "name a thread of your own");
}

void Registry::leave(ProgramId id, const std::string& why) {
  const auto found = programs_.find(id);
  if (found == programs_.end()) return;
  for (const NodeId node : found->second.nodes) scheduler_.leave(node, why);
  if (found->second.service) scheduler_.forget_cpus_of(*found->second.service);
  programs_.erase(found);
}

void Registry::find_threads() {
  for (auto& [id, program] : programs_) find_threads(program);
}

// A process that has connected twice is told of once: by its first connection that runs nodes.
void Registry::look_at_ordinary_threads(TimePoint now) {
  if (!scheduler_.real_time()) return;
  std::set<os::ThreadId> left_out = threads_of_nodes();
  left_out.merge(services());
  std::set<os::ProcessId> looked_at;
  for (auto& [id, program] : programs_) {
    if (program.nodes.empty() || !looked_at.insert(program.process).second) continue;
    const OrdinaryThreads::News news = program.ordinary.look(now, sample(program, left_out));
    if (news.threads.empty()) continue;
    scheduler_.notice("ordinary-threads", notice_of(describe(program), news, [this](os::ThreadId thread) {
                        return threads_.thread_name(thread);
                      }));
  }
}

// Threads of which the system does not tell are left out.
std::vector<OrdinaryThreads::Sample> Registry::sample(const Program& program,
                                                      const std::set<os::ThreadId>& left_out) const {
  std::vector<OrdinaryThreads::Sample> samples;
  const Result<Threads> living = threads_.threads(program.process);
  if (!living) return samples;
  for (const os::ThreadId thread : *living) {
    if (left_out.contains(thread)) continue;
    const std::optional<Nanos> ready = threads_.ready_time(thread);
    const Result<Nanos> cpu = threads_.thread_cpu_time(thread);
    if (ready && cpu) samples.push_back({thread, *ready, *cpu});
  }
  return samples;
}

std::string Registry::describe(const Program& program) const {
  std::string nodes;
  for (const NodeId node : program.nodes) {
    nodes += (nodes.empty() ? "" : ", ") + scheduler_.app().graph.node(node).name;
  }
  return fmt::format("program {} (process {}, nodes {})",
                     printable(threads_.thread_name(threads_.main_thread(program.process))),
                     static_cast<std::int32_t>(program.process), nodes);
}

void Registry::find_threads(Program& program) {
  if (program.nodes.empty() && program.shared.empty()) return;
  const Result<Threads> living = threads_.threads(program.process);
  if (!living) return;  // it is ending, and its connection will be closed
  for (const NodeId node : program.nodes) {
    for (const os::ThreadId thread : scheduler_.threads(node)) {
      if (!std::binary_search(living->begin(), living->end(), thread)) scheduler_.remove_thread(node, thread);
    }
  }
  std::erase_if(program.found,
                [&](os::ThreadId thread) { return !std::binary_search(living->begin(), living->end(), thread); });
  place_shared(program, *living);
  // One that has just joined may be about to join with more nodes.
  if (std::exchange(program.joined_since_search, false) || program.nodes.empty()) return;
  if (nodes_of(program.process) != 1) return;
  const NodeId node = *program.nodes.begin();
  std::set<os::ThreadId> taken = threads_of_nodes();
  taken.merge(services());
  for (const os::ThreadId thread : *living) {
    if (taken.contains(thread) || contains(program.shared, thread)) continue;
    // No room is no fault of the node: its first threads are scheduled.
    if (scheduler_.add_thread(node, program.process, thread)) program.found.push_back(thread);
  }
}

// A thread is one node's at most: what it had is restored when the node gives it up, and another node's controller
// would raise it again, for good. One that was found stays where it is: the program runs one node, which all its
// threads work for.
Status Registry::share(Program& program, os::ThreadId thread) {
  const Result<Threads> living = threads_with(program, thread);
  if (!living) return living.error();
  if (contains(program.shared, thread)) return Done{};
  const std::string named = fmt::format("thread {}", static_cast<std::int32_t>(thread));
  if (thread == program.service) {
    return Error::caller(named + " serves the connection", "name one that works for the program's nodes");
  }
  if (std::erase(program.found, thread) == 0 && threads_of_nodes().contains(thread)) {
    return Error::caller(named + " works for one node already", "name one that works for all");
  }
  program.shared.push_back(thread);
  place_shared(program, *living);
  return Done{};
}

// From now on it works for one node.
void Registry::unshare(Program& program, os::ThreadId thread) {
  if (std::erase(program.shared, thread) > 0 && program.sharer) scheduler_.remove_thread(*program.sharer, thread);
}

// place_shared() is to follow.
void Registry::hand_over_shared(Program& program) {
  const std::optional<NodeId> node = heaviest(program);
  if (node == program.sharer) return;
  for (const os::ThreadId thread : program.shared) {
    if (program.sharer) scheduler_.remove_thread(*program.sharer, thread);
  }
  program.sharer = node;
}

void Registry::place_shared(Program& program) {
  if (program.shared.empty()) return;
  if (const Result<Threads> living = threads_.threads(program.process)) place_shared(program, *living);
}

// Those that are too many for the node stay as they are, which is no fault of the program's, until there is room.
// `living`: the program's threads. Those that have ended are forgotten, since others may get their numbers.
void Registry::place_shared(Program& program, const Threads& living) {
  std::erase_if(program.shared,
                [&](os::ThreadId thread) { return !std::binary_search(living.begin(), living.end(), thread); });
  if (!program.sharer || program.shared.empty()) return;
  const std::set<os::ThreadId> taken = threads_of_nodes();
  for (const os::ThreadId thread : program.shared) {
    if (!taken.contains(thread)) static_cast<void>(scheduler_.add_thread(*program.sharer, program.process, thread));
  }
}

// Of all of them, whichever programs run them: a process may have connected twice.
std::set<os::ThreadId> Registry::threads_of_nodes() const {
  std::set<os::ThreadId> threads;
  const auto nodes = scheduler_.app().graph.nodes();
  for (std::size_t index = 0; index < nodes.size(); ++index) {
    if (nodes[index].external) continue;
    const Threads of_node = scheduler_.threads(NodeId(index));
    threads.insert(of_node.begin(), of_node.end());
  }
  return threads;
}

// Of the nodes that it runs, by the weights of the app file; unscheduled ones weigh nothing. Of several the first of
// the app file.
std::optional<NodeId> Registry::heaviest(const Program& program) const {
  const graph::App& app = scheduler_.app();
  const auto weight = [&](NodeId node) {
    const std::optional<SubchainId> subchain = app.graph.node(node).subchain;
    return subchain ? app.weight_of(*subchain) : -1.0;
  };
  std::optional<NodeId> heaviest;
  for (const NodeId node : program.nodes) {
    if (!heaviest || weight(node) > weight(*heaviest)) heaviest = node;
  }
  return heaviest;
}

// A process may have connected twice.
void Registry::give_up_found(os::ProcessId process) {
  for (auto& [id, program] : programs_) {
    if (program.process != process) continue;
    for (const NodeId node : program.nodes) {
      for (const os::ThreadId thread : program.found) scheduler_.remove_thread(node, thread);
    }
    program.found.clear();
  }
}

std::size_t Registry::nodes_of(os::ProcessId process) const {
  std::size_t count = 0;
  for (const auto& [id, program] : programs_) count += program.process == process ? program.nodes.size() : 0;
  return count;
}

// Catan's own threads in the programs.
std::set<os::ThreadId> Registry::services() const {
  std::set<os::ThreadId> threads;
  for (const auto& [id, program] : programs_) {
    if (program.service) threads.insert(*program.service);
  }
  return threads;
}

}  // namespace ctn::runtime
