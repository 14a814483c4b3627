// The clients that are served at once: a seat for each, which is a thread that serves one client at a time, and waits
// for the next one. A thread is started when it is first needed, and kept.
//
// Thread safety: all functions from the thread that lets clients in (server.h). Serving is done in the threads of the
// seats.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "os/linux/tcp.h"
#include "os/threads.h"
#include "web/stop_sign.h"

namespace ctn::web {

class Seats {
 public:
  // Serves a client until its connection is to end, or the sign to stop is given.
  using Serve = std::function<void(const os::TcpConnection& client)>;

  // References outlive it.
  Seats(os::Threads& threads, std::size_t count, const StopSign& stop, Serve serve);
  ~Seats() { end(); }
  Seats(const Seats&) = delete;
  Seats& operator=(const Seats&) = delete;

  // Takes the client, and has it served. False: no seat is free, and the client is left as it is.
  bool take(os::TcpConnection& client);
  // Cuts all clients off, and ends the threads. Precondition: the sign to stop was given, or no client was ever taken.
  void end();

 private:
  struct Seat {
    static constexpr std::uint32_t kFree = 0;
    static constexpr std::uint32_t kTaken = 1;
    static constexpr std::uint32_t kClosed = 2;
    std::atomic<std::uint32_t> state{kFree};
    std::optional<os::TcpConnection> client;  // changed under clients_
    std::unique_ptr<os::Thread> thread;
  };

  bool start_thread(Seat& seat);
  void work(Seat& seat);

  os::Threads& threads_;
  const StopSign& stop_;
  const Serve serve_;
  std::mutex clients_;
  std::deque<Seat> seats_;
};

}  // namespace ctn::web
