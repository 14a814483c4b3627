// What the simulated machine is like: what its kernel's scheduler does, and what it costs to schedule on it.
//
// Units: Nanos. Thread safety: plain values.
#pragma once

#include <optional>
#include <vector>

#include "base/time.h"

namespace ctn::sim {

// Constants, as `catan bench` measures them; the defaults are those of the virtual machine of docs/benchmarks.md. With
// all of them 0 the machine is ideal, and a simulation does exactly what the plan says.
struct MachineCosts {
  // Delays.
  Nanos timer_latency = std::chrono::microseconds{5};  // from when a timer is due until its thread can run
  Nanos timer_jitter = std::chrono::microseconds{40};  // of a real-time thread, at most so much more
  // Of an ordinary thread, so much more at least and at most: the kernel may group its timers (by 50 us), and CPUs
  // sleep that no real-time thread keeps ready.
  Nanos ordinary_timer_min = std::chrono::microseconds{50};
  Nanos ordinary_timer_max = std::chrono::microseconds{200};
  Nanos wake_same{0};                               // of a thread on the CPU of the thread that wakes it
  Nanos wake_other = std::chrono::microseconds{9};  // on another
  // CPU time.
  Nanos context_switch = std::chrono::microseconds{2};   // of the thread that is switched to
  Nanos dispatch_timer = std::chrono::microseconds{16};  // a controller that its timer woke: looks, acts, sleeps
  Nanos dispatch_event = std::chrono::microseconds{8};   // that the end of a run woke
  Nanos run_overhead = std::chrono::microseconds{2};     // a run: to be woken, to report, to wake the next
  Nanos run_jitter = std::chrono::microseconds{20};      // at most so much more: runs that do the same differ a little
  Nanos collect = std::chrono::microseconds{60};         // one step of the housekeeping thread
  Nanos planning = std::chrono::microseconds{400};       // making a new plan

  static MachineCosts none();
  // What the machine adds to a run, on average: a recorded run has it in its CPU time.
  Nanos mean_run() const { return run_overhead + run_jitter / 2; }
};

// Ordinary threads, all of one weight: each runs for a slice, then the one with the earliest virtual deadline among
// those that have had no more than their fair part (EEVDF, as Linux from 6.6 on).
struct FairScheduling {
  Nanos slice = std::chrono::milliseconds{3};
};

// Of every `period`, real-time threads get no more than `runtime` of a CPU on which an ordinary thread waits: what the
// fair server of Linux (from 6.12 on) and the throttling before come to.
struct RealTimeLimit {
  Nanos runtime = std::chrono::milliseconds{950};
  Nanos period = std::chrono::seconds{1};
};

// An ordinary thread of another program: busy for `busy` of every `period`, on one core.
struct BackgroundLoad {
  int core = 0;
  Nanos busy{0};
  Nanos period = std::chrono::milliseconds{10};
};

struct Machine {
  int cores = 1;
  MachineCosts costs{};
  FairScheduling fair{};
  std::optional<RealTimeLimit> limit = RealTimeLimit{};
  std::vector<BackgroundLoad> background{};
  bool real_time = true;  // false: levels are not permitted, so all threads stay ordinary
  // Where the runtime's own ordinary thread runs: on a CPU that is not the app's (true), or on the app's cores.
  bool housekeeping_elsewhere = true;
};

}  // namespace ctn::sim
