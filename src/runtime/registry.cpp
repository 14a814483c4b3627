#include "runtime/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace ctn::runtime {
namespace {

Status same_version(const Request& request) {
  if (request.version == kProtocolVersion) return Done{};
  return Error::caller(
      fmt::format("the program speaks version {}, the server version {}", request.version, kProtocolVersion),
      "let both be of one version");
}

bool is_control(Request::Kind kind) {
  return kind == Request::Kind::kChange || kind == Request::Kind::kStatus || kind == Request::Kind::kFlight;
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
  const std::optional<NodeId> node = scheduler_.app().graph.find_node(request.node);
  if (!node) {
    return Error::caller(fmt::format("app {} has no node '{}'", scheduler_.app().name, request.node.substr(0, 100)),
                         "use a name from its nodes section");
  }
  const os::ThreadId thread{request.thread};
  if (request.kind == Request::Kind::kJoin) {
    if (Status own = own_thread(program, thread); !own) return own;
    // Before the thread is placed as this node's: it may be among the threads that were taken for another's.
    if (!program.nodes.contains(*node)) release_found(program);
    if (Status joined = scheduler_.join(*node, program.process, thread); !joined) return joined;
    program.nodes.insert(*node);
    program.joined_since_search = true;
    return Done{};
  }
  if (!program.nodes.contains(*node)) {
    return Error::caller(fmt::format("this program does not run node {}", request.node), "join it first");
  }
  if (request.kind == Request::Kind::kLeave) {
    program.nodes.erase(*node);
    scheduler_.leave(*node, "its program has ended it");
    return Done{};
  }
  if (Status own = own_thread(program, thread); !own) return own;
  std::erase(program.found, thread);  // it has a name now
  return scheduler_.add_thread(*node, program.process, thread);
}

Status Registry::hello(Program& program, const Request& request) {
  if (Status same = same_version(request); !same) return same;
  if (program.service) return Error::caller("hello was said before", "say it once");
  const os::ThreadId thread{request.thread};
  if (Status own = own_thread(program, thread); !own) return own;
  program.service = thread;
  scheduler_.watch_cpus_of(thread);
  return Done{};
}

Status Registry::own_thread(const Program& program, os::ThreadId thread) const {
  const Result<std::vector<os::ThreadId>> threads = threads_.threads(program.process);
  if (threads && std::binary_search(threads->begin(), threads->end(), thread)) return Done{};
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

void Registry::find_threads(Program& program) {
  if (program.nodes.empty()) return;
  const Result<std::vector<os::ThreadId>> living = threads_.threads(program.process);
  if (!living) return;  // it is ending, and its connection will be closed
  for (const NodeId node : program.nodes) {
    for (const os::ThreadId thread : scheduler_.threads(node)) {
      if (!std::binary_search(living->begin(), living->end(), thread)) scheduler_.remove_thread(node, thread);
    }
  }
  std::erase_if(program.found,
                [&](os::ThreadId thread) { return !std::binary_search(living->begin(), living->end(), thread); });
  // One that has just joined may be about to join with more nodes.
  if (std::exchange(program.joined_since_search, false) || program.nodes.size() != 1) return;
  const NodeId node = *program.nodes.begin();
  const std::vector<os::ThreadId> known = scheduler_.threads(node);
  for (const os::ThreadId thread : *living) {
    if (thread == program.service || std::find(known.begin(), known.end(), thread) != known.end()) continue;
    // No room is no fault of the node: its first threads are scheduled.
    if (scheduler_.add_thread(node, program.process, thread)) program.found.push_back(thread);
  }
}

void Registry::release_found(Program& program) {
  for (const NodeId node : program.nodes) {
    for (const os::ThreadId thread : program.found) scheduler_.remove_thread(node, thread);
  }
  program.found.clear();
}

}  // namespace ctn::runtime
