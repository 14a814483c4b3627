#include "web/seats.h"

#include <system_error>
#include <utility>

#include "base/time.h"

namespace ctn::web {

Seats::Seats(os::Threads& threads, std::size_t count, const StopSign& stop, Serve serve)
    : threads_(threads), stop_(stop), serve_(std::move(serve)), seats_(count) {}

bool Seats::take(os::TcpConnection& client) {
  for (Seat& seat : seats_) {
    if (seat.state.load() != Seat::kFree) continue;
    if (!seat.thread && !start_thread(seat)) return false;
    {
      const std::lock_guard lock(clients_);
      seat.client.emplace(std::move(client));
    }
    seat.state.store(Seat::kTaken);
    threads_.wake(seat.state);
    return true;
  }
  return false;
}

bool Seats::start_thread(Seat& seat) {
  try {
    seat.thread = threads_.spawn("http", [this, &seat] { work(seat); });
    return true;
  } catch (const std::system_error&) {
    return false;  // the system gives no more threads
  }
}

void Seats::work(Seat& seat) {
  while (true) {
    const std::uint32_t state = seat.state.load();
    if (state == Seat::kClosed || stop_.given()) return;
    if (state == Seat::kFree) {
      threads_.wait(seat.state, Seat::kFree, kNever);
      continue;
    }
    serve_(*seat.client);
    {
      const std::lock_guard lock(clients_);
      seat.client.reset();
    }
    seat.state.store(Seat::kFree);
  }
}

void Seats::end() {
  for (Seat& seat : seats_) {
    std::uint32_t free = Seat::kFree;
    if (seat.state.compare_exchange_strong(free, Seat::kClosed)) threads_.wake(seat.state);
    const std::lock_guard lock(clients_);
    if (seat.client) seat.client->cut();
  }
  for (Seat& seat : seats_) seat.thread.reset();
}

}  // namespace ctn::web
