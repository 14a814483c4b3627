#include "os/linux/connection.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "os/linux/errno_text.h"
#include "os/linux/local_address.h"
#include "os/linux/process.h"

namespace ctn::os {
namespace {

constexpr int kPeerPidfd = 77;  // SO_PEERPIDFD, since Linux 6.5; not every <sys/socket.h> names it

// Room for the sender and one descriptor. What does not fit the kernel keeps to itself; alignment may let a second
// descriptor slip in.
struct alignas(cmsghdr) Control {
  std::array<char, CMSG_SPACE(sizeof(ucred)) + CMSG_SPACE(sizeof(int))> bytes{};
};

Error no_connection(const std::string& path, int error) {
  const std::string what = fmt::format("cannot connect to the server at {}", path);
  if (error == ENOENT || error == ECONNREFUSED) {
    return Error::environment(what + ": none is running there", "start it (`catan serve APP`), or name its socket");
  }
  if (error == EACCES || error == EPERM) {
    return Error::environment(what + ": not permitted", "run as a user who may write to that socket");
  }
  if (error == EAGAIN) {
    return Error::environment(what + ": too many are waiting to be let in",
                              "try again; restart the server if it hangs");
  }
  if (error == EPROTOTYPE || error == ENOTSOCK) {
    return Error::environment(what + ": it belongs to another program", "name the socket of `catan serve`");
  }
  return Error::environment(fmt::format("{}: {}", what, errno_text(error)), "check the path and its folder");
}

// SO_PEERPIDFD is about the very process that connected; a number alone may have passed on to another since.
Descriptor watch_peer(const Descriptor& socket, ProcessId process) {
  int number = -1;
  socklen_t size = sizeof number;
  if (::getsockopt(socket.number(), SOL_SOCKET, kPeerPidfd, &number, &size) == 0) return Descriptor(number);
  return watch_process(process);
}

void take_descriptors(const cmsghdr& header, Message& message) {
  const std::size_t count = (header.cmsg_len - CMSG_LEN(0)) / sizeof(int);
  for (std::size_t i = 0; i < count; ++i) {
    int number = -1;
    std::memcpy(&number, CMSG_DATA(&header) + i * sizeof number, sizeof number);
    Descriptor descriptor(number);
    if (message.descriptor.valid()) {
      message.surplus = true;
    } else {
      message.descriptor = std::move(descriptor);
    }
  }
}

// Whether the kernel named the sender, which it does for each message and not for the end of all.
bool take_control(msghdr& received, Message& message) {
  bool named = false;
  for (cmsghdr* header = CMSG_FIRSTHDR(&received); header != nullptr; header = CMSG_NXTHDR(&received, header)) {
    if (header->cmsg_level != SOL_SOCKET) continue;
    if (header->cmsg_type == SCM_RIGHTS) take_descriptors(*header, message);
    if (header->cmsg_type == SCM_CREDENTIALS) {
      ucred sender{};
      std::memcpy(&sender, CMSG_DATA(header), sizeof sender);
      message.sender = {ProcessId{sender.pid}, sender.uid, sender.gid};
      named = true;
    }
  }
  message.surplus = message.surplus || (received.msg_flags & MSG_CTRUNC) != 0;
  return named;
}

}  // namespace

Connection::Connection(Descriptor socket, Descriptor process, Peer peer)
    : socket_(std::move(socket)), process_(std::move(process)), peer_(peer) {}

Result<Connection> Connection::connect(const std::string& path) {
  const auto address = local_address(path);
  if (!address.ok()) return address.error();
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.valid()) return no_connection(path, errno);
  const auto* const generic = reinterpret_cast<const sockaddr*>(&*address);
  if (::connect(socket.number(), generic, sizeof(sockaddr_un)) != 0) return no_connection(path, errno);
  auto connection = adopt(std::move(socket));
  if (!connection.ok()) return connection.error();
  if (!connection->has_value()) return no_connection(path, ECONNREFUSED);
  return std::move(**connection);
}

Result<std::optional<Connection>> Connection::adopt(Descriptor socket) {
  ucred found{};
  socklen_t size = sizeof found;
  const int yes = 1;
  if (::setsockopt(socket.number(), SOL_SOCKET, SO_PASSCRED, &yes, sizeof yes) != 0 ||
      ::getsockopt(socket.number(), SOL_SOCKET, SO_PEERCRED, &found, &size) != 0) {
    return Error::environment("cannot tell who is at the other end of a connection: " + errno_text(errno),
                              "please report it with the kernel's version");
  }
  const Peer peer{ProcessId{found.pid}, found.uid, found.gid};
  Descriptor process = watch_peer(socket, peer.process);
  if (!process.valid() && errno == ESRCH) return std::optional<Connection>();
  if (!process.valid() && (errno == EMFILE || errno == ENFILE)) {
    return Error::environment(fmt::format("cannot watch process {}, which connected: {}", found.pid, errno_text(errno)),
                              "let fewer clients connect, or raise the limit of open files (`ulimit -n`)");
  }
  return std::optional<Connection>(Connection(std::move(socket), std::move(process), peer));
}

Status Connection::send(std::string_view text, const Descriptor* passed) const {
  if (text.empty() || text.size() > kMaxMessage) {
    return Error::caller(fmt::format("a message cannot have {} bytes", text.size()),
                         fmt::format("send 1 to {} bytes", kMaxMessage));
  }
  iovec part{const_cast<char*>(text.data()), text.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  Control control;
  if (passed != nullptr) {
    message.msg_control = control.bytes.data();
    message.msg_controllen = CMSG_SPACE(sizeof(int));
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    const int number = passed->number();
    std::memcpy(CMSG_DATA(header), &number, sizeof number);
  }
  ssize_t sent = -1;
  do {
    sent = ::sendmsg(socket_.number(), &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  if (sent >= 0) return Done{};
  const std::string what = fmt::format("cannot send a message to process {}", static_cast<int>(peer_.process));
  if (errno == EAGAIN) {
    return Error::environment(what + ": it does not read what it was sent", "see whether it hangs, and restart it");
  }
  if (errno == EPIPE || errno == ECONNRESET || errno == ENOTCONN) {
    return Error::environment(what + ": it has closed the connection", "start it again");
  }
  return Error::environment(fmt::format("{}: {}", what, errno_text(errno)), "see what the system lacks");
}

Arrival Connection::receive(Message& message) const {
  message = Message{};
  message.text.resize(kMaxMessage);
  iovec part{message.text.data(), message.text.size()};
  Control control;
  msghdr received{};
  ssize_t count = -1;
  do {
    received = msghdr{};
    received.msg_iov = &part;
    received.msg_iovlen = 1;
    received.msg_control = control.bytes.data();
    received.msg_controllen = control.bytes.size();
    count = ::recvmsg(socket_.number(), &received, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  } while (count < 0 && errno == EINTR);
  message.text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  if (count < 0) return errno == EAGAIN ? Arrival::kNothing : Arrival::kClosed;
  const bool named = take_control(received, message);
  message.truncated = (received.msg_flags & MSG_TRUNC) != 0;
  return count > 0 || named ? Arrival::kMessage : Arrival::kClosed;
}

}  // namespace ctn::os
