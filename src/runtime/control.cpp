#include "runtime/control.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "os/linux/connection.h"
#include "os/linux/poller.h"
#include "runtime/protocol.h"

namespace ctn::runtime {
namespace {

constexpr Nanos kAnswerWithin = std::chrono::seconds{2};

Result<os::Connection> connect_to_first(const std::vector<std::string>& sockets) {
  std::optional<Error> refusal;
  for (const std::string& path : sockets) {
    Result<os::Connection> connection = os::Connection::connect(path);
    if (connection) return connection;
    refusal = connection.error();
  }
  if (sockets.size() == 1) return *refusal;
  return Error::environment(fmt::format("no server answers at {}", fmt::join(sockets, " or ")),
                            "start one: catan serve APP.yaml; or name its socket");
}

Result<os::Message> ask_server(os::Clock& clock, const std::vector<std::string>& sockets, const Request& request) {
  const Result<os::Connection> connection = connect_to_first(sockets);
  if (!connection) return connection.error();
  const Result<std::unique_ptr<os::Poller>> poller = os::Poller::make();
  if (!poller) return poller.error();
  if (Status added = (*poller)->add(connection->socket(), 1); !added) return added.error();
  const std::string text = to_text(request);
  if (text.size() > os::kMaxMessage) return Error::caller("this is more than one message holds", "change less at once");
  // Where it turned this program away it has said why, and closed: that is still there to be read.
  static_cast<void>(connection->send(text));
  os::Message answer;
  const TimePoint deadline = clock.now() + kAnswerWithin;
  while (clock.now() < deadline) {
    switch (connection->receive(answer)) {
      case os::Arrival::kMessage:
        return answer;
      case os::Arrival::kClosed:
        return Error::environment("the server hung up", "try again");
      case os::Arrival::kNothing:
        (*poller)->wait(deadline);
    }
  }
  return Error::environment("the server does not answer", "check whether it was stopped");
}

Error not_understood() {
  return Error::environment("the server's answer was not understood", "let `catan` and the server be of one version");
}

// What comes with the answer.
Result<os::Descriptor> ask_for_memory(os::Clock& clock, const std::vector<std::string>& sockets, Request::Kind kind) {
  Result<os::Message> answer = ask_server(clock, sockets, {.kind = kind});
  if (!answer) return answer.error();
  if (Status told = parse_reply(answer->text); !told) return told.error();
  if (!answer->descriptor.valid()) return not_understood();
  return std::move(answer->descriptor);
}

}  // namespace

Status ask_to_change(os::Clock& clock, const std::vector<std::string>& sockets, const Changes& changes) {
  const Result<os::Message> answer = ask_server(clock, sockets, {.kind = Request::Kind::kChange, .changes = changes});
  if (!answer) return answer.error();
  return parse_reply(answer->text);
}

Result<std::string> ask_for_status(os::Clock& clock, const std::vector<std::string>& sockets) {
  Result<os::Descriptor> told = ask_for_memory(clock, sockets, Request::Kind::kStatus);
  if (!told) return told.error();
  const Result<os::SharedMemory> memory = os::SharedMemory::open(std::move(*told));
  if (!memory) return memory.error();
  return from_memory(*memory);
}

Result<os::Descriptor> ask_for_flight(os::Clock& clock, const std::vector<std::string>& sockets) {
  return ask_for_memory(clock, sockets, Request::Kind::kFlight);
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
