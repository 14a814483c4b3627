// Which thread has which CPU, when threads of a FakeOs compete: plain data, no threads, and time is an argument.
//
// A claim is a thread that can run: with CPU time left to consume, or with none left, and then it only waits for a CPU
// to go on to its next instruction. Each CPU serves one claim at a time:
//   - Levels: a claim that finds no free CPU takes the CPU of one of a lower level: the lowest, and among those the one
//     last in line. Of several free CPUs it takes the one it had last, else the lowest number. A thread that has a CPU
//     never moves to make room, nor when a better CPU gets free.
//   - The line: among equals, first come first served. A thread that is pre-empted keeps its place, so it is the first
//     of those that wait for that CPU. As on Linux, a raised thread goes to the end of its new level's line, a lowered
//     one to the front; lowered to the ordinary level, to the end.
//   - Ordinary claims take turns: after kSlice of CPU time with more to consume, one goes to the end of the line.
//   - A claim that loses a CPU it could use, to a change of affinity or with a CPU that goes offline, goes to the end,
//     unless it is on another CPU and keeps that.
// Nothing is kept for ordinary threads: real-time levels may take all of a CPU.
//
// Units: as os.h. Thread safety: none. Changes take effect in the next assign().
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "os/os.h"

namespace ctn::os {

class FakeCpus {
 public:
  static constexpr Nanos kSlice = std::chrono::milliseconds(3);

  // A thread had a CPU for a while, at one level.
  struct Stretch {
    int cpu;
    ThreadId thread;
    Level level;
    TimePoint begin;
    TimePoint end;
    friend bool operator==(const Stretch&, const Stretch&) = default;
  };

  // A claim at the end of its level's line, with nothing to consume. Precondition: it has none; `usable` is not empty.
  void add(ThreadId thread, Level level, const CpuSet& usable);
  void remove(ThreadId thread);
  bool has(ThreadId thread) const { return claims_.contains(thread); }
  // That it has, or had last.
  std::optional<int> cpu_of(ThreadId thread) const;
  // For a claim that exists.
  void consume(ThreadId thread, Nanos cpu_time);
  void to_the_end(ThreadId thread);
  // Of a thread that has no claim: without effect.
  void set_level(ThreadId thread, Level level);
  void set_usable(ThreadId thread, const CpuSet& usable);

  void assign();
  // After assign(): a thread that has a CPU and nothing left to consume; the highest level, of those the first in line.
  std::optional<ThreadId> ready() const;
  // After assign(), with no task ready: until one is, or a slice ends. Empty when no CPU is used.
  std::optional<Nanos> next_event() const;
  // After assign(): the threads that have no CPU.
  std::vector<ThreadId> waiting() const;
  // Precondition: duration <= next_event(). Returns the threads that had a CPU.
  std::vector<ThreadId> pass(TimePoint now, Nanos duration);

  // In the order in which they began, of those by CPU. A stretch goes on while the same thread keeps CPU and level.
  const std::vector<Stretch>& stretches() const { return stretches_; }
  // "has CPU 1, 3 ms to go"; empty for a thread without a claim.
  std::string describe(ThreadId thread) const;

 private:
  struct Claim {
    ThreadId thread{};
    Level level{};
    CpuSet usable;
    Nanos left{0};
    Nanos slice = kSlice;
    std::int64_t place = 0;  // in the line; less is first
    std::optional<int> cpu;

    bool spent() const { return level == Level::kOrdinary && slice <= Nanos{0} && left > Nanos{0}; }
  };

  void requeue(Claim& claim, std::int64_t place);
  std::vector<Claim*> waiting_in_line();
  bool place(Claim& claim);
  Claim* holder(int cpu);
  std::optional<int> free_cpu(const Claim& claim);
  Claim* lowest_holder(const Claim& claim);
  void record(const Claim& claim, TimePoint begin, TimePoint end);

  std::map<ThreadId, Claim> claims_;
  std::map<ThreadId, int> last_cpu_;
  std::int64_t front_ = 0;
  std::int64_t end_ = 0;
  std::vector<Stretch> stretches_;
  std::map<int, std::size_t> last_stretch_;  // of each CPU
};

}  // namespace ctn::os
