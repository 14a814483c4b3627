// TCP for a server that does not trust its clients: an address, a listener, and connections on which every wait has a
// deadline. A client that is slow, silent or gone costs a thread no longer than that.
//
// Addresses are numbers (IPv4 or IPv6) and `localhost`: no name is ever looked up, which could take long and depend on
// other machines.
//
// Units: TimePoint of the monotonic clock. Thread safety: parse functions are pure; a listener is one thread's; of a
// connection, reading is one thread's, writing is one thread's, and cut() any thread's while the connection lives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "base/time.h"
#include "os/linux/descriptor.h"

namespace ctn::os {

struct TcpAddress {
  std::string host;  // as numbers, without brackets
  std::uint16_t port = 0;
  friend bool operator==(const TcpAddress&, const TcpAddress&) = default;
};

// "8080" and "localhost:8080" (both 127.0.0.1), "192.168.0.7:8080", "[::1]:8080"; port 0: the system chooses one.
// kCaller: anything else.
Result<TcpAddress> parse_tcp_address(std::string_view text);
// "127.0.0.1:8080", "[::1]:8080".
std::string to_string(const TcpAddress& address);

// Of a host without brackets: whether it is an address in numbers, and one that only this machine reaches.
bool is_numeric_host(std::string_view host);
bool is_loopback_host(std::string_view host);

class TcpConnection {
 public:
  enum class Outcome { kDone, kClosed, kTimedOut };
  struct Received {
    Outcome outcome = Outcome::kClosed;
    std::size_t bytes = 0;
  };

  // kEnvironment: no server listens there, or it does not answer in time.
  static Result<TcpConnection> connect(const TcpAddress& address, TimePoint deadline);
  // A connected socket that does not block.
  explicit TcpConnection(Descriptor socket) : socket_(std::move(socket)) {}

  // Waits until there is something to read; up to `size` bytes of it.
  Received receive(char* to, std::size_t size, TimePoint deadline) const;
  // Writes all of it, or says why not.
  Outcome send(std::string_view text, TimePoint deadline) const;
  // Writes what fits into the system's buffer now; the number of bytes.
  std::size_t send_now(std::string_view text) const;
  // Whether the other end has hung up, or broken the connection.
  bool hung_up() const;
  // Nothing more will be written. The other end can still read what was.
  void finish() const;
  // Ends it in both directions, at once: a thread that waits on it goes on.
  void cut() const;

  // Readable when receive() has something to tell.
  const Descriptor& socket() const { return socket_; }

 private:
  Descriptor socket_;
};

class TcpListener {
 public:
  // kEnvironment: the address is in use, not this machine's, or not permitted.
  static Result<TcpListener> open(const TcpAddress& address);

  // The next client that waits to be let in; nothing when none does. One for which this process has no descriptor left
  // is turned away.
  std::optional<TcpConnection> accept();

  // With the port that the system chose.
  const TcpAddress& address() const { return address_; }
  // Readable when a client waits.
  const Descriptor& socket() const { return socket_; }

 private:
  TcpListener(TcpAddress address, Descriptor socket, Descriptor spare);

  TcpAddress address_;
  Descriptor socket_;
  Descriptor spare_;  // closed while a client is turned away because there are no descriptors left
};

}  // namespace ctn::os
