#include "runtime/client_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

namespace ctn::runtime {
namespace {

constexpr Nanos kAnswerTimeout = std::chrono::seconds{2};
constexpr os::Poller::Key kSocket = 1;
constexpr os::Poller::Key kProcess = 2;

Error no_server(const std::vector<std::string>& sockets) {
  return Error::environment(fmt::format("no server answers at {}", fmt::join(sockets, " or ")),
                            "start one: catan serve APP.yaml");
}

Error lost() { return Error::environment("the connection to the server was lost", "try again when it is back"); }

}  // namespace

// One connection, which two threads read: the one that waits for an answer, and the one that watches for its end.
class ClientLink::Line {
 public:
  Line(os::Connection connection, std::unique_ptr<os::Poller> answers)
      : answers_(std::move(answers)), state_(std::move(connection)) {}

  Status open() {
    const auto state = state_.lock();
    return answers_->add(state->connection->socket(), kSocket);
  }

  Status watch_with(os::Poller& watcher) {
    const auto state = state_.lock();
    if (!state->connection) return lost();
    if (Status added = watcher.add(state->connection->socket(), kSocket); !added) return added;
    if (state->connection->process().valid()) {
      if (Status added = watcher.add(state->connection->process(), kProcess); !added) return added;
    }
    state->watcher = &watcher;
    return Done{};
  }

  Status send(const std::string& text) {
    const auto state = state_.lock();
    if (!state->connection) return lost();
    state->awaits = true;
    return state->connection->send(text);
  }

  // For the thread that waits for an answer.
  os::Arrival receive(os::Message& answer) {
    const auto state = state_.lock();
    read_in(*state);
    if (!state->arrived.empty()) {
      answer = std::move(state->arrived.front());
      state->arrived.pop_front();
      state->awaits = false;
      return os::Arrival::kMessage;
    }
    return state->connection ? os::Arrival::kNothing : os::Arrival::kClosed;
  }
  void wait_for_answer(TimePoint deadline) { answers_->wait(deadline); }

  // For the thread that watches the connection. `readable`: there is something to read, or the end of the connection.
  bool has_ended(bool readable) {
    const auto state = state_.lock();
    if (readable) read_in(*state);
    return !state->connection;
  }

  void hang_up() { close(*state_.lock()); }

 private:
  struct State {
    explicit State(os::Connection connected) : connection(std::move(connected)) {}

    std::optional<os::Connection> connection;
    os::Poller* watcher = nullptr;
    std::deque<os::Message> arrived;
    bool awaits = false;  // what comes unasked is dropped
  };

  void read_in(State& state) {
    os::Message message;
    while (state.connection) {
      switch (state.connection->receive(message)) {
        case os::Arrival::kNothing:
          return;
        case os::Arrival::kClosed:
          return close(state);
        case os::Arrival::kMessage:
          if (!state.awaits) break;
          state.arrived.push_back(std::move(message));
          answers_->wake();  // the watching thread may have read it
      }
    }
  }

  void close(State& state) {
    if (!state.connection) return;
    answers_->remove(state.connection->socket());
    if (state.watcher != nullptr) {
      state.watcher->remove(state.connection->socket());
      if (state.connection->process().valid()) state.watcher->remove(state.connection->process());
      state.watcher->wake();
    }
    state.connection.reset();
    answers_->wake();
  }

  std::unique_ptr<os::Poller> answers_;
  Guarded<State> state_;
};

ClientLink::~ClientLink() = default;

Result<std::shared_ptr<ClientLink::Line>> ClientLink::connect() const {
  std::optional<Error> refusal;
  for (const std::string& path : sockets_) {
    Result<os::Connection> connection = os::Connection::connect(path);
    if (!connection) {
      refusal = connection.error();
      continue;
    }
    Result<std::unique_ptr<os::Poller>> answers = os::Poller::make();
    if (!answers) return answers.error();
    auto line = std::make_shared<Line>(std::move(*connection), std::move(*answers));
    if (Status opened = line->open(); !opened) return opened.error();
    return line;
  }
  return sockets_.size() == 1 && refusal ? *refusal : no_server(sockets_);
}

class ClientLink::LockedConversation : public Conversation {
 public:
  explicit LockedConversation(ClientLink& link) : link_(link), lock_(link.conversation_) {}

  Result<os::SharedMemory> dial(os::ThreadId service, const Meanwhile& meanwhile) override {
    return link_.dial(service, meanwhile);
  }
  Status call(const Request& request, const Meanwhile& meanwhile) override { return link_.call(request, meanwhile); }

 private:
  ClientLink& link_;
  std::unique_lock<std::mutex> lock_;
};

std::unique_ptr<Conversation> ClientLink::converse() { return std::make_unique<LockedConversation>(*this); }

Result<os::SharedMemory> ClientLink::dial(os::ThreadId service, const Meanwhile& meanwhile) {
  hang_up();
  if (!watcher_) {
    Result<std::unique_ptr<os::Poller>> watcher = os::Poller::make();
    if (!watcher) return watcher.error();
    watcher_ = std::move(*watcher);
  }
  Result<std::shared_ptr<Line>> line = connect();
  if (!line) return line.error();
  Request hello;
  hello.thread = static_cast<std::int32_t>(service);
  Result<os::Message> answer = ask(*line, hello, meanwhile);
  if (!answer) return answer.error();
  if (Status welcome = parse_reply(answer->text); !welcome) return welcome.error();
  Result<os::SharedMemory> memory = os::SharedMemory::open(std::move(answer->descriptor));
  if (!memory) return memory;
  if (Status watched = (*line)->watch_with(*watcher_); !watched) return watched.error();
  current_.lock()->line = std::move(*line);
  return memory;
}

Result<os::Message> ClientLink::ask(const std::shared_ptr<Line>& line, const Request& request,
                                    const Meanwhile& meanwhile) {
  if (Status sent = line->send(to_text(request)); !sent) return sent.error();
  const TimePoint deadline = clock_.now() + kAnswerTimeout;
  os::Message answer;
  while (clock_.now() < deadline) {
    const os::Arrival arrival = line->receive(answer);
    if (arrival == os::Arrival::kMessage) return answer;
    if (arrival == os::Arrival::kClosed) return lost();
    TimePoint until = deadline;
    if (meanwhile) {
      const std::optional<TimePoint> again = meanwhile();
      if (!again) break;
      until = std::min(until, *again);
    }
    line->wait_for_answer(until);
  }
  return Error::environment("the server does not answer", "check whether it was stopped");
}

Status ClientLink::call(const Request& request, const Meanwhile& meanwhile) {
  const std::shared_ptr<Line> line = current_.lock()->line;
  if (!line) return lost();
  const Result<os::Message> answer = ask(line, request, meanwhile);
  if (answer) return parse_reply(answer->text);
  drop(line);
  return answer.error();
}

void ClientLink::drop(const std::shared_ptr<Line>& line) {
  {
    const auto current = current_.lock();
    if (current->line != line) return;
    current->line.reset();
    current->unanswered = true;
  }
  line->hang_up();
  watcher_->wake();
}

bool ClientLink::wait(TimePoint deadline) {
  bool process_ended = false;
  bool readable = false;
  for (const os::Poller::Key key : watcher_->wait(deadline)) {
    process_ended = process_ended || key == kProcess;
    readable = readable || key == kSocket;
  }
  std::shared_ptr<Line> line;
  {
    const auto current = current_.lock();
    if (std::exchange(current->unanswered, false)) return true;
    line = current->line;
  }
  if (!line || (!process_ended && !line->has_ended(readable))) return false;
  hang_up();
  return true;
}

void ClientLink::wake() {
  if (watcher_) watcher_->wake();
}

void ClientLink::hang_up() {
  std::shared_ptr<Line> line;
  {
    const auto current = current_.lock();
    line = std::exchange(current->line, nullptr);
    current->unanswered = false;
  }
  if (line) line->hang_up();
}

}  // namespace ctn::runtime
