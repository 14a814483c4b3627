// The CPUs of the simulated machine and the threads that compete for them, in virtual time, as Linux would have it: a
// thread of a higher real-time level pre-empts all below; within a level, first come first served; what real-time
// threads leave goes to ordinary ones, fairly (machine.h). It knows nothing of nodes: what a thread does when it gets a
// CPU, and when its work is done, it asks its Client.
//
// Real-time threads that may run on one CPU only queue there. Others queue together: the highest of them goes where the
// lowest runs, rather where it ran last. Raised threads go to the end of their level's queue, lowered and pre-empted
// ones to its front.
//
// Threads with a reservation of CPU time (reservation_server.h) are above all levels, as SCHED_DEADLINE is above
// SCHED_FIFO: of those that have budget, on K CPUs the K with the earliest deadlines run; a thread that has spent its
// budget waits for the next, even where a CPU is idle. Budgets are not scaled by the speed of a CPU. The real-time
// limit does not keep them from a CPU, but what they use counts.
//
// Ordinary threads stay on the CPU that they ran on last, unless another is idle when they wake; a CPU that becomes
// idle takes a thread that waits on another.
//
// Units: Nanos of CPU time on the CPU that it is used on. Cost: an event is one step in a heap and looks at the queues
// of one CPU; nothing is allocated once running. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/time.h"
#include "os/level.h"
#include "sim/cpu_mask.h"
#include "sim/event_queue.h"
#include "sim/machine.h"
#include "sim/reservation_server.h"

namespace ctn::sim {

class Cpus {
 public:
  using Thread = std::uint32_t;
  // The number of an os::Level, and one more: 0 is ordinary, the higher pre-empts the lower.
  using LevelNumber = int;
  // Of threads with a reservation.
  static constexpr LevelNumber kReserved = static_cast<LevelNumber>(os::Level::kDispatcher) + 1 + os::kFixedLevels;

  // What threads do.
  class Client {
   public:
    virtual ~Client() = default;
    // A thread that was woken has got a CPU: what CPU time it needs until it is done.
    virtual Nanos begin(Thread thread, int cpu) = 0;
    // It has had that. True: it starts again at once; false: it sleeps until it is woken.
    virtual bool done(Thread thread, int cpu) = 0;
  };

  // CPU time by the level of the threads that used it.
  struct Used {
    Nanos real_time{0};  // above the ordinary level
    Nanos ordinary{0};
  };

  // Threads 0 to `threads` - 1; each is asleep, at the ordinary level, and may run on CPU 0. `speeds`: one a CPU.
  // `client` outlives it.
  Cpus(const Machine& machine, std::vector<double> speeds, std::size_t threads, Client& client);

  TimePoint now() const { return now_; }
  // Lets everything happen that is due by then.
  void run_until(TimePoint end);
  // run_until() returns once all that happens at this instant has, and does nothing from then on.
  void stop() { stopped_ = true; }

  // Ends its reservation, if it has one. Precondition: below kReserved.
  void set_level(Thread thread, LevelNumber level);
  // In place of a level; what was left of an earlier one is forgotten. Preconditions: 0 < runtime <= period.
  void reserve(Thread thread, Nanos runtime, Nanos period);
  void set_cpus(Thread thread, CpuMask cpus);
  LevelNumber level(Thread thread) const { return threads_[thread].level; }

  // A thread that sleeps wakes: some latency from now, depending on the CPU that wakes it (-1: none). One that does
  // not sleep is left alone.
  void wake(Thread thread, int from_cpu);
  // The same at that time, plus a timer's latency; of several calls the last counts. kNever: not at all. For a thread
  // that is about to sleep, or sleeps.
  void wake_at(Thread thread, TimePoint time);

  // CPU time that a thread has used so far.
  Nanos used_by(Thread thread);
  // That a CPU has been used, since the last call of forget_use().
  Used use_of(int cpu);
  void forget_use();
  std::uint64_t events() const { return events_; }
  // How often the limit kept real-time threads from a CPU.
  std::uint64_t throttled() const { return throttled_; }

 private:
  enum class State : std::uint8_t {
    kAsleep,
    kReady,
    kRunning,
    kNoBudget
  };  // the last: it waits for budget, in no queue
  static constexpr Thread kNoThread = 0xffffffff;

  struct Entity {
    CpuMask cpus = CpuMask::only(0);
    bool pinned = true;  // to one CPU
    LevelNumber level = 0;
    State state = State::kAsleep;
    bool begun = false;      // since it was woken
    std::int32_t cpu = 0;    // where it runs, waits or ran last
    std::int64_t order = 0;  // within its level: the lowest first; with a reservation, its deadline
    Nanos left{0};
    Nanos used{0};
    // Ordinary threads; virtual time of the CPU they are on.
    std::int64_t vruntime = 0;
    std::int64_t deadline = 0;
    std::int64_t protected_until = 0;  // in its virtual time: no thread that wakes takes the CPU from it before
    std::int64_t lag = 0;              // when it last left a CPU's queue
    std::int64_t left_at = 0;          // the CPU's virtual time then
    std::uint64_t timers = 0;          // set so far
    bool competes = false;             // on a CPU, for its fair part: it runs or waits there
  };
  struct Cpu {
    Thread current = kNoThread;
    Thread last = kNoThread;
    TimePoint since{};          // accounted for up to here
    std::vector<Thread> queue;  // real-time, pinned to this CPU; the next at the back
    std::vector<Thread> fair;   // ordinary threads that wait
    std::int64_t virtual_time = 0;
    Used used;
    std::int64_t window = 0;  // of the real-time limit
    Nanos used_in_window{0};
    double speed = 1.0;
  };

  EventQueue::Source source_of(Thread thread) const { return static_cast<EventQueue::Source>(cpus_.size()) + thread; }
  void touch(int cpu) { dirty_.add(cpu); }
  LevelNumber level_on(const Cpu& cpu) const { return cpu.current == kNoThread ? -1 : threads_[cpu.current].level; }

  void cpu_event(int cpu);
  void account(int cpu);
  void finish(int cpu);
  void settle();
  void reschedule(int cpu);
  void switch_to(int cpu, Thread next);
  void move_to(int cpu, Entity& entity) const;
  void begin_work(int cpu, Thread thread);
  void arm(int cpu);

  void make_ready(Thread thread);
  void take_off_level(Thread thread);
  void put_on_level(Thread thread);
  bool has_budget(Thread thread);
  void replenish(Thread thread);
  void give_way_without_budget(int cpu);
  void put_in_queue(Thread thread);
  void take_out_of_queue(Thread thread);
  bool before(Thread a, Thread b) const;
  void insert(std::vector<Thread>& queue, Thread thread);
  int place_for_roaming(const Entity& entity) const;
  Thread best_real_time(int cpu) const;

  int place_for_ordinary(const Entity& entity) const;
  void join_fair(Thread thread, int cpu);
  void leave_fair(Thread thread);
  std::int64_t virtual_time(int cpu);
  Nanos timer_latency(Thread thread);
  void begin_slices_until_now(Entity& entity) const;
  Thread best_ordinary(int cpu);
  Thread pull_ordinary(int cpu);

  bool limited(int cpu) const;
  void enter_window(Cpu& cpu);

  MachineCosts costs_;
  FairScheduling fair_;
  std::optional<RealTimeLimit> limit_;
  Client& client_;
  TimePoint now_{};
  std::vector<Entity> threads_;
  std::vector<Cpu> cpus_;
  std::vector<std::optional<ReservationServer>> servers_;  // by thread; empty where no thread has one
  std::vector<Thread> roaming_;  // real-time threads that may run on several CPUs and wait; the next at the back
  EventQueue events_due_;
  CpuMask dirty_;  // CPUs on which another thread may have to run
  std::int64_t first_order_ = 0;
  std::int64_t last_order_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t throttled_ = 0;
  bool stopped_ = false;
};

}  // namespace ctn::sim
