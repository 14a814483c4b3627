// Ordinary threads: what real-time threads leave is shared among them as Linux does it (EEVDF): of those that have had
// no more than their part, the one with the earliest deadline runs next.
#include <algorithm>

#include "sim/cpus.h"

namespace ctn::sim {

int Cpus::place_for_ordinary(const Entity& entity) const {
  const auto idle = [&](int number) {
    const Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
    return cpu.current == kNoThread && cpu.fair.empty() && cpu.queue.empty();
  };
  const int stay = entity.cpus.has(entity.cpu) ? entity.cpu : entity.cpus.lowest();
  if (entity.pinned || idle(stay)) return stay;
  for (CpuMask others = entity.cpus; !others.empty();) {
    const int cpu = others.take_lowest();
    if (idle(cpu)) return cpu;
  }
  return stay;
}

// The average of what all threads that compete have had.
std::int64_t Cpus::virtual_time(int number) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  std::int64_t sum = 0;
  std::int64_t count = 0;
  const auto add = [&](Thread thread) {
    sum += threads_[thread].vruntime - cpu.virtual_time;
    ++count;
  };
  if (cpu.current != kNoThread && threads_[cpu.current].level == 0) add(cpu.current);
  for (const Thread thread : cpu.fair) add(thread);
  if (count > 0) cpu.virtual_time += sum / count;
  return cpu.virtual_time;
}

// It keeps the lag that it had when it last left the queue; if it had more than its part, that is forgotten as others
// catch up.
void Cpus::join_fair(Thread thread, int number) {
  account(number);
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  Entity& entity = threads_[thread];
  if (cpu.fair.empty() && cpu.current != kNoThread && cpu.current != thread && threads_[cpu.current].level == 0) {
    begin_slices_until_now(threads_[cpu.current]);
  }
  if (entity.competes) {  // it was only pre-empted
    cpu.fair.push_back(thread);
    return;
  }
  const std::int64_t virtual_now = virtual_time(number);
  auto competitors = static_cast<std::int64_t>(cpu.fair.size());
  if (cpu.current != kNoThread && cpu.current != thread && threads_[cpu.current].level == 0) ++competitors;
  std::int64_t lag = entity.lag;
  if (lag < 0) lag = std::min<std::int64_t>(0, lag + std::max<std::int64_t>(virtual_now - entity.left_at, 0));
  if (competitors > 0) lag = lag * (competitors + 1) / competitors;
  entity.vruntime = virtual_now - lag;
  entity.deadline = entity.vruntime + fair_.slice.count();
  entity.competes = true;
  cpu.fair.push_back(thread);
}

void Cpus::leave_fair(Thread thread) {
  Entity& entity = threads_[thread];
  account(entity.cpu);
  const std::int64_t max = 2 * fair_.slice.count();
  const std::int64_t virtual_now = virtual_time(entity.cpu);
  entity.lag = std::clamp(virtual_now - entity.vruntime, -max, max);
  entity.left_at = virtual_now;
  entity.competes = false;
}

// A thread that runs alone goes on from slice to slice.
void Cpus::begin_slices_until_now(Entity& entity) const {
  const std::int64_t slice = fair_.slice.count();
  if (entity.deadline <= entity.vruntime) {
    entity.deadline += ((entity.vruntime - entity.deadline) / slice + 1) * slice;
  }
}

// Of the threads that wait and the one that runs. A thread that is given the CPU has it for a slice; if it has had more
// than its part since, it gives way to any thread that wakes.
Cpus::Thread Cpus::best_ordinary(int number) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  Thread current = cpu.current;
  if (current != kNoThread && threads_[current].level > 0) current = kNoThread;
  if (cpu.fair.empty()) return current;
  bool begins_another = false;
  if (current != kNoThread) {
    Entity& entity = threads_[current];
    if (entity.vruntime < entity.protected_until) return current;
    begins_another = entity.vruntime >= entity.deadline;
    if (begins_another) entity.deadline = entity.vruntime + fair_.slice.count();
  }
  const std::int64_t virtual_now = virtual_time(number);
  Thread best = kNoThread;
  Thread min = kNoThread;  // rounding may leave no thread below the average
  const auto consider = [&](Thread thread) {
    const Entity& entity = threads_[thread];
    if (min == kNoThread || entity.vruntime < threads_[min].vruntime) min = thread;
    if (entity.vruntime > virtual_now) return;
    if (best == kNoThread || entity.deadline < threads_[best].deadline) best = thread;
  };
  for (const Thread thread : cpu.fair) consider(thread);
  // As much as its part is as good as more: a thread that wakes with nothing to its credit goes first, too.
  if (current != kNoThread && (best == kNoThread || threads_[current].vruntime < virtual_now)) consider(current);
  const Thread chosen = best != kNoThread ? best : min;
  if (chosen == current && current != kNoThread && begins_another) {
    threads_[current].protected_until = threads_[current].deadline;
  }
  return chosen;
}

// One that waits elsewhere, for a CPU that would be idle.
Cpus::Thread Cpus::pull_ordinary(int number) {
  std::size_t max = 0;
  Thread found = kNoThread;
  for (const Cpu& cpu : cpus_) {
    if (cpu.fair.size() <= max) continue;
    const auto may = std::find_if(cpu.fair.begin(), cpu.fair.end(),
                                  [&](Thread thread) { return threads_[thread].cpus.has(number); });
    if (may == cpu.fair.end()) continue;
    max = cpu.fair.size();
    found = *may;
  }
  if (found == kNoThread) return kNoThread;
  Entity& entity = threads_[found];
  leave_fair(found);
  take_out_of_queue(found);
  move_to(number, entity);
  entity.left_at = virtual_time(number);
  join_fair(found, number);
  return found;
}

}  // namespace ctn::sim
