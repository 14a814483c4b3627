#include "os/linux/tcp.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <ctime>
#include <limits>
#include <utility>

#include "base/text.h"
#include "os/linux/errno_text.h"

namespace ctn::os {
namespace {

constexpr int kTcpWaiting = 64;  // clients that may wait to be let in
constexpr const char* kAddressHint = "write PORT, ADDRESS:PORT or [IPv6-ADDRESS]:PORT, as in 127.0.0.1:8080";

struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;
  const sockaddr* generic() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

std::optional<in_addr> ipv4_of(std::string_view host) {
  in_addr address{};
  return ::inet_pton(AF_INET, std::string(host).c_str(), &address) == 1 ? std::optional(address) : std::nullopt;
}

std::optional<in6_addr> ipv6_of(std::string_view host) {
  in6_addr address{};
  return ::inet_pton(AF_INET6, std::string(host).c_str(), &address) == 1 ? std::optional(address) : std::nullopt;
}

std::optional<SocketAddress> socket_address(const TcpAddress& address) {
  SocketAddress result;
  if (const auto four = ipv4_of(address.host)) {
    auto& in = reinterpret_cast<sockaddr_in&>(result.storage);
    in.sin_family = AF_INET;
    in.sin_port = htons(address.port);
    in.sin_addr = *four;
    result.length = sizeof in;
    return result;
  }
  if (const auto six = ipv6_of(address.host)) {
    auto& in = reinterpret_cast<sockaddr_in6&>(result.storage);
    in.sin6_family = AF_INET6;
    in.sin6_port = htons(address.port);
    in.sin6_addr = *six;
    result.length = sizeof in;
    return result;
  }
  return std::nullopt;
}

std::uint16_t port_of(const sockaddr_storage& storage) {
  return ntohs(storage.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(storage).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(storage).sin_port);
}

Error no_address(std::string_view text) {
  return Error::caller(fmt::format("{} is no address to listen at", quote(text)), kAddressHint);
}

Error cannot_listen_at(const TcpAddress& address, int error) {
  const std::string what = "cannot listen at " + to_string(address) + ": ";
  if (error == EADDRINUSE) {
    return Error::environment(what + "another program does",
                              "end that one, or name another port; with port 0 the system chooses one that is free");
  }
  if (error == EADDRNOTAVAIL) {
    return Error::environment(what + "it is no address of this machine", "see `ip address` for those that are");
  }
  if (error == EACCES) {
    return Error::environment(what + "not permitted", "name a port from 1024 up, or run it as root");
  }
  if (error == EAFNOSUPPORT) return Error::environment(what + errno_text(error), "name an IPv4 address");
  return Error::environment(what + errno_text(error), "name another address");
}

TimePoint now_monotonic() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return TimePoint{std::chrono::seconds{now.tv_sec} + Nanos{now.tv_nsec}};
}

// False: the deadline passed first.
bool wait_for(const Descriptor& socket, short what, TimePoint deadline) {
  while (true) {
    int timeout_ms = -1;
    if (deadline != kNever) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - now_monotonic());
      if (left.count() <= 0) return false;
      timeout_ms = static_cast<int>(std::min<std::int64_t>(left.count(), std::numeric_limits<int>::max()));
    }
    pollfd source{socket.number(), what, 0};
    const int found = ::poll(&source, 1, timeout_ms);
    if (found > 0) return true;
    if (found < 0 && errno != EINTR) return true;  // what is done next tells
  }
}

Descriptor open_spare_file() { return Descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

}  // namespace

Result<TcpAddress> parse_tcp_address(std::string_view text) {
  TcpAddress address{"127.0.0.1", 0};
  std::string_view port = text;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos) {
    std::string_view host = text.substr(0, colon);
    port = text.substr(colon + 1);
    const bool bracketed = host.size() >= 2 && host.front() == '[' && host.back() == ']';
    if (bracketed) host = host.substr(1, host.size() - 2);
    if (!bracketed && host == "localhost") host = "127.0.0.1";
    // Without brackets it cannot be told where an IPv6 address ends.
    if (host.find('\0') != std::string_view::npos || (bracketed ? !ipv6_of(host) : !ipv4_of(host))) {
      return no_address(text);
    }
    address.host = host;
  }
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (port.empty() || error != std::errc{} || end != port.data() + port.size()) return no_address(text);
  return address;
}

std::string to_string(const TcpAddress& address) {
  const bool brackets = address.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}:{}", brackets ? "[" : "", address.host, brackets ? "]" : "", address.port);
}

bool is_numeric_host(std::string_view host) {
  return host.find('\0') == std::string_view::npos && (ipv4_of(host) || ipv6_of(host));
}

bool is_loopback_host(std::string_view host) {
  if (host.find('\0') != std::string_view::npos) return false;
  if (const auto four = ipv4_of(host)) return (ntohl(four->s_addr) >> 24U) == 127;
  const auto six = ipv6_of(host);
  return six && IN6_IS_ADDR_LOOPBACK(&*six);
}

Result<TcpConnection> TcpConnection::connect(const TcpAddress& address, TimePoint deadline) {
  const auto to = socket_address(address);
  if (!to) return no_address(address.host);
  const auto failed = [&](int error) {
    return Error::environment(fmt::format("cannot connect to {}: {}", to_string(address), errno_text(error)),
                              "check whether a server listens there");
  };
  Descriptor socket(::socket(to->storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.valid()) return failed(errno);
  if (::connect(socket.number(), to->generic(), to->length) != 0) {
    if (errno != EINPROGRESS) return failed(errno);
    if (!wait_for(socket, POLLOUT, deadline)) return failed(ETIMEDOUT);
    int error = 0;
    socklen_t length = sizeof error;
    ::getsockopt(socket.number(), SOL_SOCKET, SO_ERROR, &error, &length);
    if (error != 0) return failed(error);
  }
  return TcpConnection(std::move(socket));
}

TcpConnection::Received TcpConnection::receive(char* to, std::size_t size, TimePoint deadline) const {
  while (true) {
    const ssize_t bytes = ::recv(socket_.number(), to, size, MSG_DONTWAIT);
    if (bytes > 0) return {Outcome::kDone, static_cast<std::size_t>(bytes)};
    if (bytes == 0) return {Outcome::kClosed, 0};
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) return {Outcome::kClosed, 0};
    if (!wait_for(socket_, POLLIN, deadline)) return {Outcome::kTimedOut, 0};
  }
}

TcpConnection::Outcome TcpConnection::send(std::string_view text, TimePoint deadline) const {
  while (!text.empty()) {
    const ssize_t bytes = ::send(socket_.number(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (bytes >= 0) {
      text.remove_prefix(static_cast<std::size_t>(bytes));
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) return Outcome::kClosed;
    if (!wait_for(socket_, POLLOUT, deadline)) return Outcome::kTimedOut;
  }
  return Outcome::kDone;
}

std::size_t TcpConnection::send_now(std::string_view text) const {
  const ssize_t bytes = ::send(socket_.number(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

bool TcpConnection::hung_up() const {
  pollfd source{socket_.number(), POLLRDHUP, 0};
  return ::poll(&source, 1, 0) > 0;
}

void TcpConnection::finish() const { ::shutdown(socket_.number(), SHUT_WR); }

void TcpConnection::cut() const { ::shutdown(socket_.number(), SHUT_RDWR); }

TcpListener::TcpListener(TcpAddress address, Descriptor socket, Descriptor spare)
    : address_(std::move(address)), socket_(std::move(socket)), spare_(std::move(spare)) {}

Result<TcpListener> TcpListener::open(const TcpAddress& address) {
  const auto at = socket_address(address);
  if (!at) return no_address(address.host);
  Descriptor socket(::socket(at->storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.valid()) return cannot_listen_at(address, errno);
  const int yes = 1;
  // A server that was just ended leaves connections behind, which would hold the port for a minute.
  ::setsockopt(socket.number(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (at->storage.ss_family == AF_INET6) ::setsockopt(socket.number(), IPPROTO_IPV6, IPV6_V6ONLY, &yes, sizeof yes);
  if (::bind(socket.number(), at->generic(), at->length) != 0 || ::listen(socket.number(), kTcpWaiting) != 0) {
    return cannot_listen_at(address, errno);
  }
  SocketAddress bound;
  bound.length = sizeof bound.storage;
  if (::getsockname(socket.number(), reinterpret_cast<sockaddr*>(&bound.storage), &bound.length) != 0) {
    return cannot_listen_at(address, errno);
  }
  return TcpListener({address.host, port_of(bound.storage)}, std::move(socket), open_spare_file());
}

std::optional<TcpConnection> TcpListener::accept() {
  while (true) {
    Descriptor socket(::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket.valid()) {
      const int yes = 1;
      ::setsockopt(socket.number(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      return TcpConnection(std::move(socket));
    }
    if (errno == EINTR || errno == ECONNABORTED) continue;
    if (errno == EMFILE || errno == ENFILE) {
      // It would wait for ever, and the socket stay readable: it is let in and out again.
      spare_.reset();
      Descriptor(::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC)).reset();
      spare_ = open_spare_file();
    }
    return std::nullopt;
  }
}

}  // namespace ctn::os
