#include "os/linux/listener.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "os/linux/errno_text.h"
#include "os/linux/local_address.h"

namespace ctn::os {
namespace {

constexpr mode_t kFolderMode = 0755;
constexpr int kWaiting = 128;  // clients that may wait to be let in

Error cannot_listen(const std::string& path, const std::string& why, std::string hint) {
  return Error::environment(fmt::format("cannot listen at {}: {}", path, why), std::move(hint));
}

Error failed(const std::string& path, int error) {
  if (error == EACCES || error == EPERM || error == EROFS) {
    return cannot_listen(path, "not permitted", "run as a user who may write to its folder, or name another path");
  }
  if (error == EMFILE) return cannot_listen(path, errno_text(error), "raise the limit of open files (`ulimit -n`)");
  if (error == ENFILE) {
    return cannot_listen(path, errno_text(error), "close programs, or raise the system's limit (`sysctl fs.file-max`)");
  }
  return cannot_listen(path, errno_text(error), "name another path");
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

Descriptor make_socket() { return Descriptor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)); }

Descriptor open_spare() { return Descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

const sockaddr* generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

// Holds off other servers that start in the same folder at the same time. A user who may read the folder can hold this
// lock, so it is not waited for long: without it, all that is lost is the right order of two servers that race.
Descriptor lock_folder(const std::string& folder) {
  constexpr int kTries = 100;
  constexpr auto kPause = std::chrono::milliseconds(10);
  Descriptor lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  for (int i = 0; lock.valid() && i < kTries; ++i) {
    if (::flock(lock.number(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) break;
    std::this_thread::sleep_for(kPause);
  }
  return lock;
}

Status make_folder(const std::string& path) {
  const std::string folder = folder_of(path);
  if (::mkdir(folder.c_str(), kFolderMode) == 0) {
    // What the process hides by default it does not mean to hide here.
    return ::chmod(folder.c_str(), kFolderMode) == 0 ? Status(Done{}) : Status(failed(path, errno));
  }
  if (errno == EEXIST) return Done{};
  if (errno == ENOENT) {
    return cannot_listen(path, fmt::format("the folder above {} is missing", folder), "make it, or name another path");
  }
  return failed(path, errno);
}

// Removes a socket that no process listens on.
Status clear_path(const std::string& path, const sockaddr_un& address) {
  struct stat file {};
  if (::lstat(path.c_str(), &file) != 0) return errno == ENOENT ? Status(Done{}) : Status(failed(path, errno));
  if (!S_ISSOCK(file.st_mode)) {
    return Error::caller(fmt::format("cannot listen at {}: something else is there, which is no socket", path),
                         "name another path");
  }
  const Descriptor probe = make_socket();
  if (!probe.valid()) return failed(path, errno);
  const bool answers = ::connect(probe.number(), generic(address), sizeof address) == 0;
  if (answers || errno == EAGAIN) {
    return cannot_listen(path, "another server is running there", "stop that one first, or name another path");
  }
  if (errno == EPROTOTYPE) return cannot_listen(path, "it belongs to another program", "name another path");
  if (errno != ECONNREFUSED && errno != ENOENT) return failed(path, errno);
  return ::unlink(path.c_str()) == 0 || errno == ENOENT ? Status(Done{}) : Status(failed(path, errno));
}

}  // namespace

Listener::Listener(std::string path, Descriptor socket, Descriptor spare, FileIdentity identity)
    : path_(std::move(path)), socket_(std::move(socket)), spare_(std::move(spare)), identity_(identity) {}

Listener::~Listener() { remove_path(); }

Listener& Listener::operator=(Listener&& other) noexcept {
  if (this == &other) return *this;
  remove_path();
  path_ = std::move(other.path_);
  socket_ = std::move(other.socket_);
  spare_ = std::move(other.spare_);
  identity_ = other.identity_;
  return *this;
}

std::optional<Listener::FileIdentity> Listener::identify(const std::string& path) {
  struct stat file {};
  if (::lstat(path.c_str(), &file) != 0) return std::nullopt;
  return FileIdentity{file.st_dev, file.st_ino};
}

void Listener::remove_path() {
  if (socket_.valid() && identify(path_) == identity_) ::unlink(path_.c_str());
}

Result<Listener> Listener::open(const std::string& path, unsigned mode) {
  const auto address = local_address(path);
  if (!address.ok()) return address.error();
  if (Status made = make_folder(path); !made.ok()) return made.error();
  const Descriptor lock = lock_folder(folder_of(path));
  if (Status cleared = clear_path(path, *address); !cleared.ok()) return cleared.error();
  Descriptor socket = make_socket();
  if (!socket.valid()) return failed(path, errno);
  if (::bind(socket.number(), generic(*address), sizeof *address) != 0) return failed(path, errno);
  const auto identity = identify(path);
  // No client can connect before listen(), so none gets in that the mode keeps out.
  const int yes = 1;
  if (!identity || ::chmod(path.c_str(), mode) != 0 ||
      ::setsockopt(socket.number(), SOL_SOCKET, SO_PASSCRED, &yes, sizeof yes) != 0 ||
      ::listen(socket.number(), kWaiting) != 0) {
    const int error = errno;
    ::unlink(path.c_str());
    return failed(path, error);
  }
  return Listener(path, std::move(socket), open_spare(), *identity);
}

// A client that cannot be let in would wait for ever, and the socket stay readable: it is let in and out again.
Result<std::optional<Connection>> Listener::turn_away() {
  const int error = errno;
  spare_.reset();
  const bool waited = Descriptor(::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC)).valid();
  const bool none_waits = !waited && errno == EAGAIN;  // the kernel looks for a descriptor first, and for a client then
  spare_ = open_spare();
  if (none_waits) return std::optional<Connection>();
  return Error::environment(fmt::format("turned a client away at {}: {}", path_, errno_text(error)),
                            "let fewer clients connect, or raise the limit of open files (`ulimit -n`)");
}

Result<std::optional<Connection>> Listener::accept() {
  while (true) {
    Descriptor socket(::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket.valid()) {
      auto connection = Connection::adopt(std::move(socket));
      if (!connection.ok() || connection->has_value()) return connection;
      continue;
    }
    if (errno == EAGAIN) return std::optional<Connection>();
    if (errno != EINTR && errno != ECONNABORTED) return turn_away();
  }
}

}  // namespace ctn::os
