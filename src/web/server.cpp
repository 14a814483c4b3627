#include "web/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "os/linux/poller.h"
#include "web/assets.h"
#include "web/change_request.h"
#include "web/http_library.h"
#include "web/metrics.h"
#include "web/request_head.h"

namespace ctn::web {
namespace {

using Outcome = os::TcpConnection::Outcome;

constexpr const char* kJson = "application/json";

// The page loads nothing from elsewhere, browsers keep nothing, and no page of another site may show or read it.
constexpr std::array<std::pair<const char*, const char*>, 6> kSafety{
    {{"Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
     {"X-Content-Type-Options", "nosniff"},
     {"X-Frame-Options", "DENY"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Cache-Control", "no-store"}}};

const char* reason_of(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 411:
      return "Length Required";
    case 413:
      return "Payload Too Large";
    case 414:
      return "URI Too Long";
    case 415:
      return "Unsupported Media Type";
    case 417:
      return "Expectation Failed";
    case 431:
      return "Request Header Fields Too Large";
    case 501:
      return "Not Implemented";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Error";
  }
}

// The whole answer to a request that is refused; the connection ends after it.
std::string answer_of(const Refusal& refusal) {
  const std::string body = error_json(refusal.what, refusal.hint);
  std::string text = fmt::format("HTTP/1.1 {} {}\r\nConnection: close\r\nContent-Type: {}\r\nContent-Length: {}\r\n",
                                 refusal.status, reason_of(refusal.status), kJson, body.size());
  if (refusal.status == 401) text += "WWW-Authenticate: Bearer\r\n";
  if (refusal.status == 405) text += "Allow: GET, HEAD, POST\r\n";
  if (refusal.status == 503) text += "Retry-After: 1\r\n";
  for (const auto& [name, value] : kSafety) text += fmt::format("{}: {}\r\n", name, value);
  return text + "\r\n" + body;
}

// A server-sent event, in which each line of the text is a field of its own.
std::string event_of(std::string_view name, std::string_view text) {
  std::string event = fmt::format("event: {}\n", name);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) event += fmt::format("data: {}\n", text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return event + "\n";
}

// The stream from which the HTTP library reads a request, and to which it writes the answer: the head, written anew,
// then as much of the body as the head announced.
class RequestStream final : public httplib::Stream {
 public:
  // `received`: what has come after the head. The body is taken out, and what follows it is left there.
  RequestStream(os::Clock& clock, const os::TcpConnection& client, const Limits& limits, const RequestHead& head,
                std::string& received)
      : clock_(clock), client_(client), limits_(limits), text_(canonical(head)) {
    const std::size_t there = std::min(head.content_length, received.size());
    text_ += received.substr(0, there);
    received.erase(0, there);
    body_left_ = head.content_length - there;
    read_by_ = clock.now() + limits.request;
  }

  // Whether all of the body was read.
  bool read_all() const { return body_left_ == 0; }

  bool is_readable() const override { return place_ < text_.size() || body_left_ > 0; }
  bool is_writable() const override { return !client_.hung_up(); }
  ssize_t read(char* to, std::size_t size) override {
    if (place_ < text_.size()) {
      const std::size_t count = text_.copy(to, size, place_);
      place_ += count;
      return static_cast<ssize_t>(count);
    }
    if (body_left_ == 0) return 0;
    const auto got = client_.receive(to, std::min(size, body_left_), read_by_);
    if (got.outcome != Outcome::kDone) return -1;
    body_left_ -= got.bytes;
    return static_cast<ssize_t>(got.bytes);
  }
  ssize_t write(const char* from, std::size_t size) override {
    const Outcome outcome = client_.send({from, size}, clock_.now() + limits_.answer);
    return outcome == Outcome::kDone ? static_cast<ssize_t>(size) : -1;
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return client_.socket().number(); }

 private:
  os::Clock& clock_;
  const os::TcpConnection& client_;
  const Limits& limits_;
  std::string text_;
  std::size_t place_ = 0;  // how much of text_ was read
  std::size_t body_left_ = 0;
  TimePoint read_by_{};
};

// The HTTP library, without its sockets and threads.
class Library final : public httplib::Server {
 public:
  // The library takes a server without a socket for a stopped one, and ends its streams.
  void started(int socket) { svr_sock_ = socket; }
  void stopped() { svr_sock_ = INVALID_SOCKET; }
  // False: the connection must be closed.
  bool answer(httplib::Stream& stream, bool last) {
    bool closed = false;
    return process_request(stream, last, closed, nullptr) && !closed;
  }
};

// A document of the source, kept for a moment, so that the source is asked seldom, however many clients ask.
class Document {
 public:
  using Text = std::shared_ptr<const Result<std::string>>;
  using Ask = std::function<Result<std::string>()>;

  Document(os::Clock& clock, Nanos kept_for, Ask ask) : clock_(clock), kept_for_(kept_for), ask_(std::move(ask)) {}

  Text get() {
    const std::lock_guard lock(mutex_);
    if (!text_ || clock_.now() >= stale_at_) {
      text_ = std::make_shared<const Result<std::string>>(ask_());
      stale_at_ = clock_.now() + kept_for_;
    }
    return text_;
  }
  void forget() {
    const std::lock_guard lock(mutex_);
    text_.reset();
  }

 private:
  os::Clock& clock_;
  const Nanos kept_for_;
  const Ask ask_;
  std::mutex mutex_;
  TimePoint stale_at_{};
  Text text_;
};

int status_of(const Error& error) { return error.kind() == ErrorKind::kCaller ? 400 : 503; }

void fail(httplib::Response& response, int status, const std::string& body) {
  response.status = status;
  response.set_content(body, kJson);
}

}  // namespace

struct Server::Impl {
  // A thread that serves one client at a time, and waits for the next one.
  struct Seat {
    static constexpr std::uint32_t kFree = 0;
    static constexpr std::uint32_t kTaken = 1;
    static constexpr std::uint32_t kClosed = 2;
    std::atomic<std::uint32_t> state{kFree};
    std::optional<os::TcpConnection> client;  // changed under `clients`
    std::unique_ptr<os::Thread> thread;
  };
  // A client that got 503 because no seat was free, until it has taken the answer.
  struct Leaving {
    os::TcpConnection client;
    TimePoint until{};
    std::size_t heard = 0;
  };

  static constexpr os::Poller::Key kListener = 0;
  static constexpr os::Poller::Key kFirstLeaving = 1U << 20U;
  static constexpr std::size_t kMaxLeaving = 64;
  static constexpr std::size_t kMaxHeard = std::size_t{64} * 1024;
  static constexpr Nanos kLeaveWithin = std::chrono::seconds{1};

  Impl(os::Os& system, Source& shown, os::TcpListener listening, std::unique_ptr<os::Poller> waits,
       std::optional<std::string> token, const Limits& max)
      : os(system),
        source(shown),
        listener(std::move(listening)),
        poller(std::move(waits)),
        limits(max),
        rules{os::is_loopback_host(listener.address().host), std::move(token)},
        live(os, limits.step * 9 / 10, [this] { return source.live(); }),
        timeline(os, limits.step * 9 / 10, [this] { return source.timeline(); }),
        snapshot(os, limits.step * 9 / 10, [this] { return source.snapshot(); }),
        plan(os, limits.step * 9 / 10, [this] { return source.plan(); }),
        seats(limits.clients) {
    route();
    library.started(listener.socket().number());
  }

  // --- What is where ---

  void route() {
    httplib::Headers headers;
    for (const auto& [name, value] : kSafety) headers.emplace(name, value);
    library.set_default_headers(headers);
    library.set_keep_alive_max_count(limits.requests);
    library.set_keep_alive_timeout(std::chrono::duration_cast<std::chrono::seconds>(limits.idle).count());
    library.set_payload_max_length(kMaxBody);
    show("/", kPage, "text/html; charset=utf-8");
    show("/style.css", kPageStyle, "text/css; charset=utf-8");
    show("/page.js", kPageScript, "text/javascript; charset=utf-8");
    show("/live", live);
    show("/timeline", timeline);
    show("/snapshot", snapshot);
    show("/plan", plan);
    library.Get("/control", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(rules.token ? "{\"allowed\":true}\n" : "{\"allowed\":false}\n", kJson);
    });
    library.Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      const Document::Text measured = snapshot.get();
      const Document::Text seen = live.get();
      response.set_content(metrics_text(*measured ? **measured : std::string(), *seen ? **seen : std::string()),
                           "text/plain; version=0.0.4; charset=utf-8");
    });
    library.Get("/events", [this](const httplib::Request&, httplib::Response& response) { stream(response); });
    library.Post("/control/change", [this](const httplib::Request& request, httplib::Response& response) {
      change(request.body, response);
    });
    library.Post("/whatif", [this](const httplib::Request& request, httplib::Response& response) {
      what_if(request.body, response);
    });
    library.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (response.body.empty()) {
        fail(response, response.status, error_json("there is no such page, or the request is wrong", "see /"));
      }
    });
    library.set_exception_handler([](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
      fail(response, 500, error_json("this is a bug in catan", "report it"));
    });
  }

  void show(const char* path, const char* text, const char* type) {
    library.Get(
        path, [text, type](const httplib::Request&, httplib::Response& response) { response.set_content(text, type); });
  }

  void show(const char* path, Document& document) {
    library.Get(path, [&document](const httplib::Request&, httplib::Response& response) {
      const Document::Text text = document.get();
      if (!*text) return fail(response, status_of(text->error()), error_json(text->error()));
      response.set_content(**text, kJson);
    });
  }

  void change(const std::string& body, httplib::Response& response) {
    const Result<Changes> changes = parse_change(body);
    if (!changes) return fail(response, 400, error_json(changes.error()));
    const std::lock_guard lock(changing);
    if (const Status done = source.change(*changes); !done) {
      return fail(response, status_of(done.error()), error_json(done.error()));
    }
    for (Document* document : {&live, &snapshot, &plan}) document->forget();
    response.set_content("{\"done\":true}\n", kJson);
  }

  // One question at a time, since each takes CPU time.
  void what_if(const std::string& body, httplib::Response& response) {
    const Result<WhatIf> asked = parse_what_if(body);
    if (!asked) return fail(response, 400, error_json(asked.error()));
    const std::unique_lock lock(asking, std::try_to_lock);
    if (!lock) {
      response.set_header("Retry-After", "1");
      return fail(response, 429, error_json("another what-if question is being answered", "ask again in a second"));
    }
    const Result<std::string> answer = source.what_if(*asked);
    if (!answer) return fail(response, status_of(answer.error()), error_json(answer.error()));
    response.set_content(*answer, kJson);
  }

  void stream(httplib::Response& response) {
    const TimePoint until = os.now() + limits.stream;
    response.set_chunked_content_provider(
        "text/event-stream", [this, until, turn = std::uint64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
          // That a client has gone is noticed when something is written to it.
          if (turn > 0) os.wait(ended, 0, std::min(until, os.now() + limits.step));
          if (ended.load() != 0 || os.now() >= until) {
            sink.done();
            return true;
          }
          std::string text = turn == 0 ? "retry: 2000\n\n" : "";
          text += event_text("live", live);
          if (turn % 2 == 0) text += event_text("timeline", timeline);
          ++turn;
          return sink.write(text.data(), text.size());
        });
  }

  static std::string event_text(std::string_view name, Document& document) {
    const Document::Text text = document.get();
    return *text ? event_of(name, **text) : event_of("trouble", error_json(text->error()));
  }

  // --- One client, in the thread of its seat ---

  void serve(const os::TcpConnection& client) {
    std::string received;
    for (std::size_t count = 1; count <= limits.requests && ended.load() == 0; ++count) {
      const auto head = receive_head(client, received);
      if (!head) return;
      if (const auto* refusal = std::get_if<Refusal>(&*head)) return refuse(client, *refusal);
      const auto& request = std::get<RequestHead>(*head);
      if (const auto refusal = check_access(request, rules)) return refuse(client, *refusal);
      if (request.expects_continue) {
        static_cast<void>(client.send("HTTP/1.1 100 Continue\r\n\r\n", os.now() + limits.answer));
      }
      RequestStream stream(os, client, limits, request, received);
      const bool last = count == limits.requests || !request.keep_alive;
      if (!library.answer(stream, last) || last) return;
      if (!stream.read_all()) return;
    }
  }

  // Nothing: the client has gone, or sent nothing in time.
  std::optional<std::variant<RequestHead, Refusal>> receive_head(const os::TcpConnection& client,
                                                                 std::string& received) {
    TimePoint deadline = os.now() + (received.empty() ? limits.idle : limits.request);
    while (true) {
      if (const auto length = head_length(received); length && *length <= kMaxHead) {
        auto head = parse_head(std::string_view(received).substr(0, *length));
        received.erase(0, *length);
        return head;
      }
      if (received.size() >= kMaxHead) return Refusal{431, "the head of the request is too long", "send less"};
      std::array<char, 4096> buffer;
      const bool first = received.empty();
      const auto got = client.receive(buffer.data(), buffer.size(), deadline);
      if (got.outcome == Outcome::kTimedOut && !first) {
        return Refusal{408, "the request did not come in time", "send it faster"};
      }
      if (got.outcome != Outcome::kDone) return std::nullopt;
      received.append(buffer.data(), got.bytes);
      if (first) deadline = os.now() + limits.request;
    }
  }

  // Where the client's data are not read, closing the connection would reset it before the client has the answer.
  void refuse(const os::TcpConnection& client, const Refusal& refusal) {
    if (client.send(answer_of(refusal), os.now() + limits.answer) != Outcome::kDone) return;
    client.finish();
    const TimePoint deadline = os.now() + std::min(kLeaveWithin, limits.answer);
    std::array<char, 4096> buffer;
    for (std::size_t heard = 0; heard < kMaxHeard;) {
      const auto got = client.receive(buffer.data(), buffer.size(), deadline);
      if (got.outcome != Outcome::kDone) return;
      heard += got.bytes;
    }
  }

  void work(Seat& seat) {
    while (true) {
      const std::uint32_t state = seat.state.load();
      if (state == Seat::kClosed || ended.load() != 0) return;
      if (state == Seat::kFree) {
        os.wait(seat.state, Seat::kFree, kNever);
        continue;
      }
      serve(*seat.client);
      {
        const std::lock_guard lock(clients);
        seat.client.reset();
      }
      seat.state.store(Seat::kFree);
    }
  }

  // --- All clients, in the thread that calls run() ---

  void run() {
    while (ended.load() == 0) {
      TimePoint next = kNever;
      for (const auto& [key, client] : leaving) next = std::min(next, client.until);
      const std::vector<os::Poller::Key> ready = poller->wait(next);
      for (const os::Poller::Key key : ready) {
        if (key == kListener) {
          let_in();
        } else if (key >= kFirstLeaving) {
          hear(key);
        } else if (key <= watched.size()) {
          watched[key - 1]();
        }
      }
      const TimePoint now = os.now();
      for (auto it = leaving.begin(); it != leaving.end();) it = it->second.until <= now ? drop(it) : std::next(it);
    }
    end();
  }

  void let_in() {
    for (int i = 0; i < 64; ++i) {
      std::optional<os::TcpConnection> client = listener.accept();
      if (!client) return;
      if (!seat(*client)) show_out(std::move(*client));
    }
  }

  bool seat(os::TcpConnection& client) {
    for (Seat& place : seats) {
      if (place.state.load() != Seat::kFree) continue;
      if (!place.thread && !start_thread(place)) return false;
      {
        const std::lock_guard lock(clients);
        place.client.emplace(std::move(client));
      }
      place.state.store(Seat::kTaken);
      os.wake(place.state);
      return true;
    }
    return false;
  }

  bool start_thread(Seat& place) {
    try {
      place.thread = os.spawn("http", [this, &place] { work(place); });
      return true;
    } catch (const std::system_error&) {
      return false;  // the system gives no more threads
    }
  }

  void show_out(os::TcpConnection client) {
    static const std::string kAnswer =
        answer_of({503, "as many clients are served as can be", "close one, or try again"});
    if (client.send_now(kAnswer) < kAnswer.size()) return;
    client.finish();
    if (leaving.size() >= kMaxLeaving) drop(leaving.begin());
    const auto it = leaving.emplace(next_key++, Leaving{std::move(client), os.now() + kLeaveWithin}).first;
    if (!poller->add(it->second.client.socket(), it->first)) leaving.erase(it);
  }

  void hear(os::Poller::Key key) {
    const auto it = leaving.find(key);
    if (it == leaving.end()) return;
    std::array<char, 4096> buffer;
    const auto got = it->second.client.receive(buffer.data(), buffer.size(), TimePoint{});
    it->second.heard += got.bytes;
    if (got.outcome != Outcome::kDone || it->second.heard >= kMaxHeard) drop(it);
  }

  std::map<os::Poller::Key, Leaving>::iterator drop(std::map<os::Poller::Key, Leaving>::iterator it) {
    poller->remove(it->second.client.socket());
    return leaving.erase(it);
  }

  void stop() {
    ended.store(1);
    os.wake(ended);
    poller->wake();
  }

  void end() {
    library.stopped();
    for (Seat& place : seats) {
      std::uint32_t free = Seat::kFree;
      if (place.state.compare_exchange_strong(free, Seat::kClosed)) os.wake(place.state);
      const std::lock_guard lock(clients);
      if (place.client) place.client->cut();
    }
    for (Seat& place : seats) place.thread.reset();
    while (!leaving.empty()) drop(leaving.begin());
  }

  os::Os& os;
  Source& source;
  os::TcpListener listener;
  std::unique_ptr<os::Poller> poller;
  const Limits limits;
  const AccessRules rules;
  Document live;
  Document timeline;
  Document snapshot;
  Document plan;
  std::mutex changing;
  std::mutex asking;
  Library library;
  std::atomic<std::uint32_t> ended{0};
  std::mutex clients;
  std::deque<Seat> seats;
  std::map<os::Poller::Key, Leaving> leaving;
  os::Poller::Key next_key = kFirstLeaving;
  std::vector<std::function<void()>> watched;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  impl_->stop();
  impl_->end();
}

Result<std::unique_ptr<Server>> Server::open(os::Os& os, Source& source, const os::TcpAddress& address,
                                             std::optional<std::string> token, const Limits& limits) {
  Result<os::TcpListener> listener = os::TcpListener::open(address);
  if (!listener) return listener.error();
  Result<std::unique_ptr<os::Poller>> poller = os::Poller::make();
  if (!poller) return poller.error();
  if (Status added = (*poller)->add(listener->socket(), Impl::kListener); !added) return added.error();
  return std::unique_ptr<Server>(new Server(
      std::make_unique<Impl>(os, source, std::move(*listener), std::move(*poller), std::move(token), limits)));
}

const os::TcpAddress& Server::address() const { return impl_->listener.address(); }

Status Server::watch(const os::Descriptor& descriptor, std::function<void()> ready) {
  impl_->watched.push_back(std::move(ready));
  return impl_->poller->add(descriptor, impl_->watched.size());
}

void Server::run() { impl_->run(); }

void Server::stop() { impl_->stop(); }

}  // namespace ctn::web
