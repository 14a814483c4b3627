#include "runtime/control.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "base/text.h"
#include "os/linux/connection.h"
#include "os/linux/poller.h"
#include "runtime/protocol.h"

namespace ctn::runtime {
namespace {

constexpr Nanos kAnswerWithin = std::chrono::seconds{2};

Error not_understood() {
  return Error::environment("the server's answer was not understood", "let `catan` and the server be of one version");
}

// A connection to one server, over which it is asked.
class ReachedServer {
 public:
  static Result<ReachedServer> begin(const std::string& socket) {
    Result<os::Connection> connection = os::Connection::connect(socket);
    if (!connection) return connection.error();
    Result<std::unique_ptr<os::Poller>> poller = os::Poller::make();
    if (!poller) return poller.error();
    if (Status added = (*poller)->add(connection->socket(), 1); !added) return added.error();
    return ReachedServer(std::move(*connection), std::move(*poller));
  }

  Result<os::Message> ask(os::Clock& clock, const Request& request);

 private:
  ReachedServer(os::Connection connection, std::unique_ptr<os::Poller> poller)
      : connection_(std::move(connection)), poller_(std::move(poller)) {}

  os::Connection connection_;
  std::unique_ptr<os::Poller> poller_;
};

Result<os::Message> ReachedServer::ask(os::Clock& clock, const Request& request) {
  const std::string text = to_text(request);
  if (text.size() > os::kMaxMessage) return Error::caller("this is more than one message holds", "change less at once");
  // Where it turned this program away it has said why, and closed: that is still there to be read.
  static_cast<void>(connection_.send(text));
  os::Message answer;
  const TimePoint deadline = clock.now() + kAnswerWithin;
  while (clock.now() < deadline) {
    switch (connection_.receive(answer)) {
      case os::Arrival::kMessage:
        return answer;
      case os::Arrival::kClosed:
        return Error::environment("the server hung up", "try again");
      case os::Arrival::kNothing:
        poller_->wait(deadline);
    }
  }
  return Error::environment("the server does not answer", "check whether it was stopped");
}

Result<std::string> app_of(os::Clock& clock, ReachedServer& reached) {
  const Result<os::Message> answer = reached.ask(clock, {.kind = Request::Kind::kApp});
  if (!answer) return answer.error();
  return parse_app_reply(answer->text);
}

Result<ReachedServer> reach(os::Clock& clock, const ServerAddress& server) {
  std::optional<Error> refusal;
  std::string others;
  for (const std::string& path : server.sockets) {
    Result<ReachedServer> reached = ReachedServer::begin(path);
    if (!reached) {
      refusal = reached.error();
      continue;
    }
    if (server.app.empty()) return reached;
    const Result<std::string> app = app_of(clock, *reached);
    if (app && *app == server.app) return reached;
    if (!app && server.sockets.size() == 1) return app.error();
    others += app ? fmt::format("; the one at {} schedules {}", path, quote(*app))
                  : fmt::format("; the one at {} does not say what it schedules: {}", path, app.error().message());
  }
  if (server.sockets.size() == 1 && refusal) return *refusal;
  const std::string of_app = others.empty() ? "" : " for " + quote(server.app);
  return Error::environment(
      fmt::format("no server answers{} at {}{}", of_app, fmt::join(server.sockets, " or "), others),
      "start one: catan serve APP.yaml; or name its socket");
}

// What comes with the answer.
Result<os::Descriptor> ask_for_memory(os::Clock& clock, const ServerAddress& server, Request::Kind kind) {
  Result<ReachedServer> reached = reach(clock, server);
  if (!reached) return reached.error();
  Result<os::Message> answer = reached->ask(clock, {.kind = kind});
  if (!answer) return answer.error();
  if (Status told = parse_reply(answer->text); !told) return told.error();
  if (!answer->descriptor.valid()) return not_understood();
  return std::move(answer->descriptor);
}

}  // namespace

Status ask_to_change(os::Clock& clock, const ServerAddress& server, const Changes& changes) {
  Result<ReachedServer> reached = reach(clock, server);
  if (!reached) return reached.error();
  const Result<os::Message> answer = reached->ask(clock, {.kind = Request::Kind::kChange, .changes = changes});
  if (!answer) return answer.error();
  return parse_reply(answer->text);
}

Result<std::string> ask_for_status(os::Clock& clock, const ServerAddress& server) {
  Result<os::Descriptor> told = ask_for_memory(clock, server, Request::Kind::kStatus);
  if (!told) return told.error();
  const Result<os::SharedMemory> memory = os::SharedMemory::open(std::move(*told));
  if (!memory) return memory.error();
  return from_memory(*memory);
}

Result<os::Descriptor> ask_for_flight(os::Clock& clock, const ServerAddress& server) {
  return ask_for_memory(clock, server, Request::Kind::kFlight);
}

Result<os::SharedMemory> to_memory(const std::string& text) {
  const std::uint64_t length = text.size();
  Result<os::SharedMemory> memory = os::SharedMemory::create("catan-status", sizeof length + text.size());
  if (!memory) return memory;
  std::memcpy(memory->bytes().data(), &length, sizeof length);
  std::memcpy(memory->bytes().data() + sizeof length, text.data(), text.size());
  return memory;
}

Result<std::string> from_memory(const os::SharedMemory& memory) {
  std::uint64_t length = 0;
  const std::size_t size = memory.bytes().size();
  if (size < sizeof length) return not_understood();
  std::memcpy(&length, memory.bytes().data(), sizeof length);
  if (length > size - sizeof length) return not_understood();
  return std::string(reinterpret_cast<const char*>(memory.bytes().data()) + sizeof length,
                     static_cast<std::size_t>(length));
}

}  // namespace ctn::runtime
