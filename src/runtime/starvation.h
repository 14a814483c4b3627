// Detects that the kernel kept a CPU from real-time threads: its fair server or its throttling gave the CPU to ordinary
// threads, as happens when plans leave too little slack. Pure.
//
// The sign: a thread at the dispatcher level, which nothing of ours outranks, woke much later than it had asked for. A
// hypervisor can cause the same; the time that it reports as taken from the CPU is subtracted. Where it reports none,
// the two cannot be told apart. A process that was stopped (dispatch/standstill.h) wakes late on all CPUs, and that is
// left out.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/time.h"

namespace ctn::runtime {

// Timers and busy kernels are late by less.
constexpr Nanos kStarvedAfter = std::chrono::milliseconds{10};

// A thread that fell asleep at `asleep` until `due` woke because its time had come.
inline bool woke_too_late(TimePoint asleep, TimePoint due, TimePoint woke) {
  return woke - (due < asleep ? asleep : due) >= kStarvedAfter;
}

class Starvation {
 public:
  // A thread on `cpu` was to wake at `due`, and did at `woke`. In the order of `woke`, for each CPU.
  void woke_late(int cpu, TimePoint due, TimePoint woke);
  // Whether something waits for stolen_until_now().
  bool has_pending() const { return !late_.empty(); }
  // What a hypervisor has taken of each CPU since boot: about once a second, and when something waits.
  void stolen_until_now(std::map<int, Nanos> stolen);

  std::uint64_t times() const { return times_; }
  Nanos total() const { return total_; }
  // What there is to tell that was not told yet: the first time at once, then every ten seconds at most.
  std::optional<std::string> message(TimePoint now);

 private:
  struct Late {
    int cpu;
    TimePoint due;
    TimePoint woke;
  };

  std::vector<Late> late_;
  std::map<int, TimePoint> counted_until_;  // by CPU: several threads see the same
  std::map<int, Nanos> stolen_;
  std::uint64_t times_ = 0;
  Nanos total_{0};
  Nanos longest_{0};
  int last_cpu_ = 0;
  // The newest time in which this process was stopped.
  TimePoint stopped_{};
  TimePoint resumed_{};
  std::uint64_t reported_ = 0;
  TimePoint reported_at_{};
};

}  // namespace ctn::runtime
