// The server's side of a Unix socket: a path at which clients connect (connection.h).
//
// Opening it takes the place of a socket that a server left behind when it was killed, but never that of a server which
// still answers, nor any other kind of file. Two servers that start at once cannot both win. Nothing blocks for longer
// than a second.
//
// Thread safety: one thread at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "os/linux/connection.h"
#include "os/linux/descriptor.h"

namespace ctn::os {

class Listener {
 public:
  // `mode` says who may connect, as in chmod: 0600 the own user, 0660 the group, too, 0666 every user. The path's
  // folder is made (0755) if it is missing. kCaller: a path that no socket can have, or one where there is something
  // else. kEnvironment: another server is there, or it is not permitted.
  static Result<Listener> open(const std::string& path, unsigned mode);
  // Removes the path, unless it is another's by now.
  ~Listener();
  Listener(Listener&&) = default;
  Listener& operator=(Listener&& other) noexcept;
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // The next client that waits to be let in; nothing when none does. One that waits but is gone already is passed over.
  // kEnvironment: a client had to be turned away, because this process has no descriptor left for it.
  Result<std::optional<Connection>> accept();

  const std::string& path() const { return path_; }
  // Readable when a client waits.
  const Descriptor& socket() const { return socket_; }

 private:
  // Of the socket's file, which tells it from one that another server put in its place.
  struct FileIdentity {
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
    friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
  };

  Listener(std::string path, Descriptor socket, Descriptor spare, FileIdentity identity);
  static std::optional<FileIdentity> identify(const std::string& path);
  Result<std::optional<Connection>> turn_away();
  void remove_path();

  std::string path_;
  Descriptor socket_;
  Descriptor spare_;  // closed while a client is turned away because there are no descriptors left
  FileIdentity identity_;
};

}  // namespace ctn::os
