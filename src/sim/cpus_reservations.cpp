// Threads with a reservation of CPU time.
#include "sim/cpus.h"

namespace ctn::sim {

void Cpus::reserve(Thread thread, Nanos runtime, Nanos period) {
  if (servers_.empty()) servers_.resize(threads_.size());
  take_off_level(thread);
  Entity& entity = threads_[thread];
  entity.level = kReserved;
  ReservationServer& server = servers_[thread].emplace(runtime, period);
  server.wake(now_);
  entity.order = server.deadline().time_since_epoch().count();
  put_on_level(thread);
}

// Of a thread that wants to run; if not, it waits until it has.
bool Cpus::has_budget(Thread thread) {
  Entity& entity = threads_[thread];
  ReservationServer& server = *servers_[thread];
  server.replenish(now_);
  server.wake(now_);
  entity.order = server.deadline().time_since_epoch().count();
  if (server.may_run()) return true;
  entity.state = State::kNoBudget;
  events_due_.set(source_of(thread), server.replenished_at());
  return false;
}

// The end of the period for which it has waited.
void Cpus::replenish(Thread thread) {
  Entity& entity = threads_[thread];
  ReservationServer& server = *servers_[thread];
  server.replenish(now_);
  entity.order = server.deadline().time_since_epoch().count();
  entity.state = State::kReady;
  put_in_queue(thread);
}

// Precondition: the thread that runs has a reservation.
void Cpus::give_way_without_budget(int number) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  const Thread thread = cpu.current;
  const ReservationServer& server = *servers_[thread];
  if (server.may_run()) return;
  cpu.current = kNoThread;
  threads_[thread].state = State::kNoBudget;
  if (server.replenished_at() <= now_) {
    replenish(thread);
  } else {
    events_due_.set(source_of(thread), server.replenished_at());
  }
}

}  // namespace ctn::sim
