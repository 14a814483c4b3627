#include "web/conversation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

#include "web/answers.h"
#include "web/http_library.h"

namespace ctn::web {
namespace {

using Outcome = os::TcpConnection::Outcome;

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

}  // namespace

void Conversation::hold() {
  for (std::size_t count = 1; count <= limits_.requests && !stop_.given(); ++count) {
    const auto head = receive_head();
    if (!head) return;
    if (const auto* refusal = std::get_if<Refusal>(&*head)) return refuse(*refusal);
    const auto& request = std::get<RequestHead>(*head);
    if (const auto refusal = check_access(request, rules_)) return refuse(*refusal);
    if (request.expects_continue) {
      static_cast<void>(client_.send("HTTP/1.1 100 Continue\r\n\r\n", clock_.now() + limits_.answer));
    }
    RequestStream stream(clock_, client_, limits_, request, received_);
    const bool last = count == limits_.requests || !request.keep_alive;
    if (!routes_.answer(stream, last) || last) return;
    if (!stream.read_all()) return;
  }
}

std::optional<std::variant<RequestHead, Refusal>> Conversation::receive_head() {
  TimePoint deadline = clock_.now() + (received_.empty() ? limits_.idle : limits_.request);
  while (true) {
    if (const auto length = head_length(received_); length && *length <= kMaxHead) {
      auto head = parse_head(std::string_view(received_).substr(0, *length));
      received_.erase(0, *length);
      return head;
    }
    if (received_.size() >= kMaxHead) return Refusal{431, "the head of the request is too long", "send less"};
    std::array<char, 4096> buffer;
    const bool first = received_.empty();
    const auto got = client_.receive(buffer.data(), buffer.size(), deadline);
    if (got.outcome == Outcome::kTimedOut && !first) {
      return Refusal{408, "the request did not come in time", "send it faster"};
    }
    if (got.outcome != Outcome::kDone) return std::nullopt;
    received_.append(buffer.data(), got.bytes);
    if (first) deadline = clock_.now() + limits_.request;
  }
}

// Where the client's data are not read, closing the connection would reset it before the client has the answer.
void Conversation::refuse(const Refusal& refusal) {
  if (client_.send(answer_of(refusal), clock_.now() + limits_.answer) != Outcome::kDone) return;
  client_.finish();
  const TimePoint deadline = clock_.now() + std::min(kLeaveWithin, limits_.answer);
  std::array<char, 4096> buffer;
  for (std::size_t heard = 0; heard < kMaxHeard;) {
    const auto got = client_.receive(buffer.data(), buffer.size(), deadline);
    if (got.outcome != Outcome::kDone) return;
    heard += got.bytes;
  }
}

}  // namespace ctn::web
