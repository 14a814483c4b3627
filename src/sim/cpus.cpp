#include "sim/cpus.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/mixed.h"

namespace ctn::sim {

MachineCosts MachineCosts::none() {
  return {.timer_latency = Nanos{0},
          .timer_jitter = Nanos{0},
          .ordinary_timer_min = Nanos{0},
          .ordinary_timer_max = Nanos{0},
          .wake_same = Nanos{0},
          .wake_other = Nanos{0},
          .context_switch = Nanos{0},
          .dispatch_timer = Nanos{0},
          .dispatch_event = Nanos{0},
          .run_overhead = Nanos{0},
          .run_jitter = Nanos{0},
          .collect = Nanos{0},
          .planning = Nanos{0}};
}

Cpus::Cpus(const Machine& machine, std::vector<double> speeds, std::size_t threads, Client& client)
    : costs_(machine.costs),
      fair_(machine.fair),
      limit_(machine.limit),
      client_(client),
      threads_(threads),
      cpus_(speeds.size()),
      events_due_(speeds.size() + threads) {
  assert(speeds.size() <= static_cast<std::size_t>(kMaxCpus));
  for (std::size_t cpu = 0; cpu < speeds.size(); ++cpu) {
    cpus_[cpu].speed = speeds[cpu];
    cpus_[cpu].queue.reserve(threads);
    cpus_[cpu].fair.reserve(threads);
  }
  roaming_.reserve(threads);
}

void Cpus::run_until(TimePoint end) {
  settle();
  while (!stopped_ && events_due_.next() <= end) {
    now_ = std::max(now_, events_due_.next());
    const EventQueue::Source source = events_due_.pop();
    ++events_;
    if (source < cpus_.size()) {
      cpu_event(static_cast<int>(source));
    } else {
      make_ready(source - static_cast<EventQueue::Source>(cpus_.size()));
    }
    settle();
  }
  if (!stopped_) now_ = std::max(now_, end);
}

// --- Which thread runs ---

void Cpus::settle() {
  while (!dirty_.empty()) reschedule(dirty_.take_lowest());
}

void Cpus::account(int number) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  const Nanos spent = now_ - cpu.since;
  if (limit_) enter_window(cpu);
  cpu.since = now_;
  if (cpu.current == kNoThread || spent == Nanos{0}) return;
  Entity& current = threads_[cpu.current];
  current.left -= spent;
  current.used += spent;
  if (current.level > 0) {
    cpu.used.real_time += spent;
    if (current.level == kReserved) servers_[cpu.current]->ran(spent);
    if (limit_) cpu.used_in_window += std::min(spent, now_.time_since_epoch() % limit_->period);
  } else {
    cpu.used.ordinary += spent;
    current.vruntime += spent.count();
  }
}

void Cpus::cpu_event(int number) {
  account(number);
  const Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  if (cpu.current != kNoThread && threads_[cpu.current].left <= Nanos{0}) {
    finish(number);
  } else {
    touch(number);
  }
}

// The current thread has had the CPU time that it needed.
void Cpus::finish(int number) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  const Thread thread = cpu.current;
  touch(number);
  if (client_.done(thread, number)) {
    threads_[thread].begun = false;
    begin_work(number, thread);
    return;
  }
  Entity& entity = threads_[thread];
  if (entity.level == 0) leave_fair(thread);
  entity.state = State::kAsleep;
  cpu.current = kNoThread;
}

void Cpus::begin_work(int number, Thread thread) {
  const Nanos work = client_.begin(thread, number);
  Entity& entity = threads_[thread];
  entity.begun = true;
  entity.left += std::max(work, Nanos{0});
}

void Cpus::reschedule(int number) {
  account(number);
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  if (cpu.current != kNoThread && threads_[cpu.current].level == kReserved) give_way_without_budget(number);
  const bool limit_reached = limited(number);
  Thread next = best_real_time(number);
  if (limit_reached && next != kNoThread && threads_[next].level < kReserved) next = kNoThread;
  if (next == kNoThread) next = best_ordinary(number);
  if (next == kNoThread && cpu.current == kNoThread) next = pull_ordinary(number);
  const LevelNumber level = level_on(cpu);
  const bool must_go = limit_reached && level > 0 && level < kReserved;
  if (must_go) ++throttled_;
  if (next != kNoThread && next != cpu.current) {
    switch_to(number, next);
  }
  arm(number);
}

void Cpus::switch_to(int number, Thread next) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  const Thread before = cpu.current;
  take_out_of_queue(next);
  cpu.current = next;
  Entity& entity = threads_[next];
  entity.state = State::kRunning;
  move_to(number, entity);
  if (entity.level == 0) {
    begin_slices_until_now(entity);
    entity.protected_until = entity.deadline;
  }
  if (before != kNoThread) {
    threads_[before].state = State::kReady;
    put_in_queue(before);
  }
  if (cpu.last != next) entity.left += costs_.context_switch;
  cpu.last = next;
  if (!entity.begun) begin_work(number, next);
}

// What is left of its work takes as long as the CPU is slow.
void Cpus::move_to(int number, Entity& entity) const {
  const double from = cpus_[static_cast<std::size_t>(entity.cpu)].speed;
  const double to = cpus_[static_cast<std::size_t>(number)].speed;
  if (entity.begun && from != to) {
    entity.left = Nanos{std::llround(static_cast<double>(entity.left.count()) * (from / to))};
  }
  entity.cpu = number;
}

// When the CPU has to be looked at next.
void Cpus::arm(int number) {
  Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  TimePoint at = kNever;
  if (cpu.current != kNoThread) {
    const Entity& current = threads_[cpu.current];
    at = now_ + std::max(current.left, Nanos{0});
    if (current.level == 0 && !cpu.fair.empty()) {
      at = std::min(at, now_ + Nanos{std::max<std::int64_t>(current.deadline - current.vruntime, 0)});
    }
    if (current.level == kReserved) {
      at = std::min(at, now_ + std::max(servers_[cpu.current]->budget(), Nanos{0}));
    } else if (current.level > 0 && limit_ && !cpu.fair.empty()) {
      const Nanos window_end = (cpu.window + 1) * limit_->period;
      const TimePoint limit_reached = now_ + std::max(limit_->runtime - cpu.used_in_window, Nanos{0});
      at = std::min(at, std::min(limit_reached, TimePoint{window_end}));
    }
  }
  if (limited(number)) at = std::min(at, TimePoint{(cpu.window + 1) * limit_->period});
  events_due_.set(static_cast<EventQueue::Source>(number), at);
}

// --- Queues ---

// Which of two threads of a queue is served first.
bool Cpus::before(Thread a, Thread b) const {
  const Entity& one = threads_[a];
  const Entity& other = threads_[b];
  return one.level > other.level || (one.level == other.level && one.order < other.order);
}

void Cpus::insert(std::vector<Thread>& queue, Thread thread) {
  auto place = queue.end();
  while (place != queue.begin() && !before(thread, *(place - 1))) --place;
  queue.insert(place, thread);
}

void Cpus::wake(Thread thread, int from_cpu) {
  const Entity& entity = threads_[thread];
  if (entity.state != State::kAsleep) return;
  const bool same = from_cpu < 0 || (entity.pinned ? entity.cpus.lowest() : entity.cpu) == from_cpu;
  const Nanos latency = same ? costs_.wake_same : costs_.wake_other;
  if (latency == Nanos{0}) {
    events_due_.set(source_of(thread), kNever);
    make_ready(thread);
  } else {
    events_due_.set(source_of(thread), std::min(events_due_.time_of(source_of(thread)), now_ + latency));
  }
}

void Cpus::wake_at(Thread thread, TimePoint time) {
  if (time == kNever) return events_due_.set(source_of(thread), kNever);
  events_due_.set(source_of(thread), std::max(time, now_) + timer_latency(thread));
}

// Anything between the minimum and the maximum, by the thread and the number of the timer alone.
Nanos Cpus::timer_latency(Thread thread) {
  Entity& entity = threads_[thread];
  const bool ordinary = entity.level == 0;
  const Nanos min = costs_.timer_latency + (ordinary ? costs_.ordinary_timer_min : Nanos{0});
  const Nanos range = ordinary ? costs_.ordinary_timer_max - costs_.ordinary_timer_min : costs_.timer_jitter;
  if (range <= Nanos{0}) return min;
  return min + chance_below(range, ++entity.timers, thread);
}

void Cpus::make_ready(Thread thread) {
  Entity& entity = threads_[thread];
  if (entity.state == State::kNoBudget) replenish(thread);
  if (entity.state != State::kAsleep) return;
  entity.state = State::kReady;
  entity.begun = false;
  entity.left = Nanos{0};
  entity.order = ++last_order_;
  if (entity.level == kReserved && !has_budget(thread)) return;
  if (entity.level == 0) entity.cpu = place_for_ordinary(entity);
  put_in_queue(thread);
}

void Cpus::put_in_queue(Thread thread) {
  Entity& entity = threads_[thread];
  if (entity.level == 0) {
    join_fair(thread, entity.cpu);
    touch(entity.cpu);
  } else if (entity.pinned) {
    const int cpu = entity.cpus.lowest();
    insert(cpus_[static_cast<std::size_t>(cpu)].queue, thread);
    touch(cpu);
  } else {
    insert(roaming_, thread);
    const int cpu = place_for_roaming(entity);
    if (dirty_.has(cpu)) {  // another thread may be about to get it: look everywhere
      for (CpuMask cpus = entity.cpus; !cpus.empty();) touch(cpus.take_lowest());
    }
    touch(cpu);
  }
}

void Cpus::take_out_of_queue(Thread thread) {
  const Entity& entity = threads_[thread];
  if (entity.level == 0) {
    std::vector<Thread>& fair = cpus_[static_cast<std::size_t>(entity.cpu)].fair;
    fair.erase(std::find(fair.begin(), fair.end(), thread));
    return;
  }
  std::vector<Thread>& queue = entity.pinned ? cpus_[static_cast<std::size_t>(entity.cpus.lowest())].queue : roaming_;
  if (queue.back() == thread) {
    queue.pop_back();
  } else {
    queue.erase(std::find(queue.begin(), queue.end(), thread));
  }
}

void Cpus::set_level(Thread thread, LevelNumber level) {
  assert(level < kReserved);
  Entity& entity = threads_[thread];
  if (entity.level == level) return;
  const bool raised = level > entity.level;
  take_off_level(thread);
  entity.level = level;
  entity.order = raised ? ++last_order_ : --first_order_;
  put_on_level(thread);
}

void Cpus::take_off_level(Thread thread) {
  Entity& entity = threads_[thread];
  if (entity.state == State::kReady) {
    if (entity.level == 0) leave_fair(thread);
    take_out_of_queue(thread);
  } else if (entity.state == State::kRunning) {
    account(entity.cpu);
    if (entity.level == 0) leave_fair(thread);
  } else if (entity.state == State::kNoBudget) {
    events_due_.set(source_of(thread), kNever);
    entity.state = State::kReady;
  }
}

void Cpus::put_on_level(Thread thread) {
  Entity& entity = threads_[thread];
  if (entity.state == State::kReady) put_in_queue(thread);
  if (entity.state == State::kRunning) {
    if (entity.level == 0) {  // it joins the threads that wait in its place
      const std::int64_t virtual_now = virtual_time(entity.cpu);
      entity.vruntime = virtual_now;
      entity.deadline = virtual_now + fair_.slice.count();
      entity.protected_until = entity.deadline;
      entity.competes = true;
    }
    touch(entity.cpu);
  }
}

void Cpus::set_cpus(Thread thread, CpuMask mask) {
  Entity& entity = threads_[thread];
  if (entity.cpus == mask) return;
  if (entity.state == State::kReady) {
    if (entity.level == 0) leave_fair(thread);
    take_out_of_queue(thread);
  }
  entity.cpus = mask;
  entity.pinned = mask.single();
  const bool stays = mask.has(entity.cpu);
  if (entity.state == State::kRunning && !stays) {
    account(entity.cpu);
    if (entity.level == 0) leave_fair(thread);
    cpus_[static_cast<std::size_t>(entity.cpu)].current = kNoThread;
    touch(entity.cpu);
    entity.state = State::kReady;
  } else if (entity.state != State::kReady) {
    if (entity.state == State::kRunning) touch(entity.cpu);
    if (!stays && entity.state == State::kAsleep) entity.cpu = mask.lowest();
    return;
  }
  if (!stays && entity.level == 0) entity.cpu = mask.lowest();
  put_in_queue(thread);
}

// Where a real-time thread that may choose pre-empts another, if it can anywhere.
int Cpus::place_for_roaming(const Entity& entity) const {
  const auto level_at = [&](int cpu) { return level_on(cpus_[static_cast<std::size_t>(cpu)]); };
  int best = entity.cpus.has(entity.cpu) ? entity.cpu : entity.cpus.lowest();
  if (level_at(best) <= 0 && level_at(best) < entity.level) return best;
  for (CpuMask others = entity.cpus; !others.empty();) {
    const int cpu = others.take_lowest();
    if (level_at(cpu) < level_at(best)) best = cpu;
  }
  if (level_at(best) < kReserved) return best;
  for (CpuMask others = entity.cpus; !others.empty();) {  // all have deadlines: the latest gives way
    const int cpu = others.take_lowest();
    if (before(cpus_[static_cast<std::size_t>(best)].current, cpus_[static_cast<std::size_t>(cpu)].current)) best = cpu;
  }
  return best;
}

// Of the threads that wait and the one that runs; kNoThread: no real-time thread at all.
Cpus::Thread Cpus::best_real_time(int number) const {
  const Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  Thread best = cpu.current != kNoThread && threads_[cpu.current].level > 0 ? cpu.current : kNoThread;
  if (!cpu.queue.empty() && (best == kNoThread || before(cpu.queue.back(), best))) best = cpu.queue.back();
  for (auto waiting = roaming_.rbegin(); waiting != roaming_.rend(); ++waiting) {
    if (best != kNoThread && !before(*waiting, best)) break;
    if (!threads_[*waiting].cpus.has(number)) continue;
    best = *waiting;
    break;
  }
  return best;
}

// --- The real-time limit ---

void Cpus::enter_window(Cpu& cpu) {
  const std::int64_t window = now_.time_since_epoch() / limit_->period;
  if (window == cpu.window) return;
  cpu.window = window;
  cpu.used_in_window = Nanos{0};
}

bool Cpus::limited(int number) const {
  if (!limit_) return false;
  const Cpu& cpu = cpus_[static_cast<std::size_t>(number)];
  const bool wanted = !cpu.fair.empty() || (cpu.current != kNoThread && threads_[cpu.current].level == 0);
  return wanted && cpu.used_in_window >= limit_->runtime;
}

// --- Use ---

Nanos Cpus::used_by(Thread thread) {
  Entity& entity = threads_[thread];
  if (entity.state == State::kRunning) account(entity.cpu);
  return entity.used;
}

Cpus::Used Cpus::use_of(int cpu) {
  account(cpu);
  return cpus_[static_cast<std::size_t>(cpu)].used;
}

void Cpus::forget_use() {
  for (std::size_t cpu = 0; cpu < cpus_.size(); ++cpu) {
    account(static_cast<int>(cpu));
    cpus_[cpu].used = {};
  }
}

}  // namespace ctn::sim
