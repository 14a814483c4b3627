// Messages between processes of one machine, over a Unix socket that keeps them apart (SOCK_SEQPACKET): each arrives
// whole, in order, and once. The kernel says which process sent each, and no sender can lie about it. listener.h makes
// the server's ends.
//
// Nothing here blocks. A process that sends faster than the other reads finds the buffer full, which is an error: a
// server drops such a client rather than wait for it.
//
// Thread safety: send() from any thread; receive() from one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "os/linux/descriptor.h"
#include "os/os.h"

namespace ctn::os {

constexpr std::size_t kMaxMessage = 4096;  // bytes

// A process as the kernel knows it. Process 0 is one that the kernel does not name: of another container, say.
struct Peer {
  ProcessId process{};
  std::uint32_t user = 0;
  std::uint32_t group = 0;
  friend bool operator==(const Peer&, const Peer&) = default;
};

struct Message {
  std::string text;        // may be empty
  bool truncated = false;  // it was longer than kMaxMessage; the rest is lost
  Descriptor descriptor;   // that was handed over with it, if one was
  bool surplus = false;    // more descriptors came, or one that this process has no number left for; they are closed
  Peer sender;             // that wrote this message: need not be the one that connected
};

enum class Arrival { kMessage, kNothing, kClosed };

class Connection {
 public:
  // To the server that listens on `path`. kCaller: a path that no socket can have. kEnvironment: no process listens
  // there, it is not permitted, or the server does not keep up.
  static Result<Connection> connect(const std::string& path);
  // From a socket that is connected, as Listener::accept() has it; nothing where the other process is gone already.
  // Until then a sender that wants to can stay unnamed (process 0) on kernels before 6.16.
  static Result<std::optional<Connection>> adopt(Descriptor socket);

  // Hands over a copy of `passed`, if given. kCaller: an empty message, or more than kMaxMessage bytes. kEnvironment:
  // the other end is closed, or its buffer is full.
  Status send(std::string_view text, const Descriptor* passed = nullptr) const;
  // kClosed: there will be no more. Overwrites `message`, which is empty unless kMessage.
  Arrival receive(Message& message) const;

  // The process that connected, or on a client's end, that listens.
  const Peer& peer() const { return peer_; }
  // Readable when receive() has something to tell.
  const Descriptor& socket() const { return socket_; }
  // Readable once the peer's process has ended, even if a child of it keeps the socket open. May be none where the
  // system does not support that.
  const Descriptor& process() const { return process_; }

 private:
  Connection(Descriptor socket, Descriptor process, Peer peer);

  Descriptor socket_;
  Descriptor process_;
  Peer peer_;
};

}  // namespace ctn::os
