// What a node's runs wait, under way: time in which they neither ran nor were ready to run, such as for an accelerator,
// a device or a file. A run that other threads kept from the CPU does not wait.
//
// A run that took no longer than its CPU time has not waited, and that is known for free. One that took longer was
// pre-empted or waited. Only then is the kernel asked, before each of the next runs, what it has counted so far, so
// that after such a run the difference tells which of the two it was. So nodes that neither wait nor are pre-empted pay
// nothing, others some microseconds a run (docs/decisions/0029-runs-that-wait.md), and of a node's waits one that comes
// after kWatchedRuns without any is missed. A run during which the thread did not block has not waited, whatever a
// hypervisor took from it. The very first run is watched, too: whatever the system opens to be asked is open then, and
// no later run pays for it.
//
// Units: Nanos. Thread safety: that of the node's own thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "os/threads.h"

namespace ctn::runtime {

class WaitWatch {
 public:
  // Shorter ones are taken for the time that it takes to switch, and to read clocks.
  static constexpr Nanos kShortestWait = std::chrono::microseconds{50};
  static constexpr int kWatchedRuns = 64;

  // `threads` outlives it.
  explicit WaitWatch(os::Threads& threads) : threads_(threads) {}

  // A run is about to begin.
  void begin() {
    before_.reset();
    if (watched_ == 0) return;
    --watched_;
    const std::optional<Nanos> ready = threads_.ready_time();
    if (ready) before_ = Counted{threads_.times_blocked(), *ready};
    tells_ = ready.has_value();
  }

  // The run has ended, after `elapsed`, and all threads of the node used `cpu`: what of it they waited. Where several
  // worked, what none of them computed, at least.
  Nanos end(Nanos elapsed, Nanos cpu) {
    const Nanos without_cpu = elapsed - cpu;
    if (without_cpu < kShortestWait) return Nanos{0};
    if (tells_) watched_ = kWatchedRuns;
    if (!before_ || threads_.times_blocked() == before_->blocked) return Nanos{0};
    const Nanos ready = threads_.ready_time().value_or(before_->ready + without_cpu) - before_->ready;
    return std::clamp(without_cpu - ready, Nanos{0}, without_cpu);
  }

 private:
  struct Counted {
    std::uint64_t blocked = 0;
    Nanos ready{0};
  };

  os::Threads& threads_;
  int watched_ = 1;                // so many runs more
  bool tells_ = true;              // the system does
  std::optional<Counted> before_;  // the run under way
};

}  // namespace ctn::runtime
