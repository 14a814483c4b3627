// Clients for which there was no seat (seats.h): each gets 503 at once, and is then listened to for a moment, since
// closing the connection before its request was read would reset it, and the client could not read why.
//
// Thread safety: none; one owner, the thread that lets clients in (server.h).
#pragma once

#include <cstddef>
#include <map>

#include "base/time.h"
#include "os/clock.h"
#include "os/linux/poller.h"
#include "os/linux/tcp.h"

namespace ctn::web {

class TurnedAway {
 public:
  static constexpr os::Poller::Key kFirstKey = 1U << 20U;  // its keys of the poller begin here
  static constexpr std::size_t kMaxClients = 64;           // more than these are cut off, the oldest first

  // References outlive it.
  TurnedAway(os::Clock& clock, os::Poller& poller) : clock_(clock), poller_(poller) {}
  ~TurnedAway() { drop_all(); }
  TurnedAway(const TurnedAway&) = delete;
  TurnedAway& operator=(const TurnedAway&) = delete;

  void add(os::TcpConnection client);
  // The poller has reported that key.
  void hear(os::Poller::Key key);
  // When the next client has had its time; kNever: there is none.
  TimePoint next() const;
  // Cuts off all clients that have had their time by now.
  void drop_overdue();
  void drop_all();

 private:
  struct Client {
    os::TcpConnection connection;
    TimePoint until{};
    std::size_t heard = 0;
  };
  using Clients = std::map<os::Poller::Key, Client>;

  Clients::iterator drop(Clients::iterator client);

  os::Clock& clock_;
  os::Poller& poller_;
  Clients clients_;
  os::Poller::Key next_key_ = kFirstKey;
};

}  // namespace ctn::web
