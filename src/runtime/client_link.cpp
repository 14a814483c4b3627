#include "runtime/client_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ctn::runtime {
namespace {

constexpr Nanos kLongestAnswer = std::chrono::seconds{2};
constexpr os::Poller::Key kSocket = 1;
constexpr os::Poller::Key kProcess = 2;

Error no_server(const std::vector<std::string>& sockets) {
  return Error::environment(fmt::format("no server answers at {}", fmt::join(sockets, " or ")),
                            "start one: catan serve APP.yaml");
}

Error lost() { return Error::environment("the connection to the server was lost", "try again when it is back"); }

}  // namespace

Result<os::SharedMemory> ClientLink::dial(os::ThreadId service, const Meanwhile& meanwhile) {
  const std::lock_guard lock(mutex_);
  connection_.reset();
  std::optional<Error> refusal;
  for (const std::string& path : sockets_) {
    Result<os::Connection> connection = os::Connection::connect(path);
    if (connection) {
      connection_.emplace(std::move(*connection));
      path_ = path;
      break;
    }
    refusal = connection.error();
  }
  if (!connection_) return sockets_.size() == 1 && refusal ? *refusal : no_server(sockets_);

  Result<std::unique_ptr<os::Poller>> watcher = os::Poller::make();
  Result<std::unique_ptr<os::Poller>> answers = os::Poller::make();
  if (!watcher || !answers) return (watcher ? answers : watcher).error();
  if (!watcher_) watcher_ = std::move(*watcher);
  answers_ = std::move(*answers);
  if (Status added = answers_->add(connection_->socket(), kSocket); !added) return added.error();

  os::Message answer;
  Request hello;
  hello.thread = static_cast<std::int32_t>(service);
  if (Status asked = ask(hello, answer, meanwhile); !asked) return asked.error();
  if (Status welcome = parse_reply(answer.text); !welcome) return welcome.error();
  Result<os::SharedMemory> memory = os::SharedMemory::open(std::move(answer.descriptor));
  if (!memory) return memory;
  if (Status watched = watcher_->add(connection_->socket(), kSocket); !watched) return watched.error();
  if (connection_->process().valid()) {
    if (Status watched = watcher_->add(connection_->process(), kProcess); !watched) return watched.error();
  }
  return memory;
}

Status ClientLink::ask(const Request& request, os::Message& answer, const Meanwhile& meanwhile) {
  if (Status sent = connection_->send(to_text(request)); !sent) return sent;
  const TimePoint deadline = os_.now() + kLongestAnswer;
  while (os_.now() < deadline) {
    switch (connection_->receive(answer)) {
      case os::Arrival::kMessage:
        return Done{};
      case os::Arrival::kClosed:
        return lost();
      case os::Arrival::kNothing:
        answers_->wait(meanwhile ? std::min(meanwhile(), deadline) : deadline);
    }
  }
  return Error::environment("the server does not answer", "look whether it was stopped");
}

Status ClientLink::call(const Request& request) {
  const std::lock_guard lock(mutex_);
  if (!connection_) return lost();
  os::Message answer;
  if (Status asked = ask(request, answer); !asked) return asked;
  return parse_reply(answer.text);
}

Result<bool> ClientLink::wait(TimePoint deadline) {
  if (!watcher_) {
    Result<std::unique_ptr<os::Poller>> watcher = os::Poller::make();
    if (!watcher) return watcher.error();
    watcher_ = std::move(*watcher);
  }
  for (const os::Poller::Key key : watcher_->wait(deadline)) {
    if (key == kProcess || server_is_gone()) {
      hang_up();
      return true;
    }
  }
  return false;
}

bool ClientLink::server_is_gone() {
  const std::lock_guard lock(mutex_);
  if (!connection_) return false;
  os::Message unasked;
  for (;;) {
    const os::Arrival arrival = connection_->receive(unasked);
    if (arrival != os::Arrival::kMessage) return arrival == os::Arrival::kClosed;
  }
}

void ClientLink::wake() {
  if (watcher_) watcher_->wake();
}

void ClientLink::hang_up() {
  const std::lock_guard lock(mutex_);
  if (!connection_) return;
  watcher_->remove(connection_->socket());
  if (connection_->process().valid()) watcher_->remove(connection_->process());
  connection_.reset();
}

}  // namespace ctn::runtime
