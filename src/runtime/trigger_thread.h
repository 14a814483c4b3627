// The thread that triggers one subchain: the pure state machine of dispatch, driven by the clock and by completions.
//
// It runs at the dispatcher level, so it never waits for a lock: new pacing reaches it through a wait-free channel, and
// what it does leaves it through a ring. It is also the watchdog of its subchain: a run that hangs at a real-time level
// is lowered to the ordinary one until it ends, so that it cannot take the machine with it.
//
// Thread safety: run() is the thread's body; the rest may be called from one other thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/enforcer.h"
#include "runtime/node_port.h"
#include "runtime/word_ring.h"

namespace ctn::runtime {

class TriggerThread {
 public:
  // `ports`: the subchain's nodes in order. All references outlive the thread.
  TriggerThread(os::Os& os, SubchainId subchain, std::vector<NodePort*> ports, SubchainSignal& signal,
                Enforcer& enforcer, const dispatch::Pacing& initial);

  void run();
  void stop();

  // In force from the next look of the thread, which is at once.
  void change_pacing(const dispatch::Pacing& pacing);

  struct Hang {
    TimePoint at;
    bool began = false;  // else: ended
  };

  // Calls take(record::Trigger) and take_hang(Hang) for all since the last call.
  template <class Take, class TakeHang>
  void drain(Take&& take, TakeHang&& take_hang);
  std::uint64_t lost_reports() const { return reports_.lost(); }

 private:
  static constexpr std::size_t kReports = 4096;
  static constexpr std::uint64_t kHangBegan = ~std::uint64_t{0};
  static constexpr std::uint64_t kHangEnded = kHangBegan - 1;

  void adopt_new_pacing(dispatch::SubchainTrigger& trigger);
  void act(const dispatch::SubchainTrigger::Decision& decision, TimePoint now, std::uint64_t number);
  void contain(bool hanging);
  void report(std::uint64_t what, TimePoint due, TimePoint sent);

  os::Os& os_;
  SubchainId subchain_;
  std::vector<NodePort*> ports_;
  SubchainSignal& signal_;
  Enforcer& enforcer_;
  dispatch::Pacing initial_;
  WordRing pacings_;
  WordRing reports_;
  std::atomic<bool> stopping_{false};
};

template <class Take, class TakeHang>
void TriggerThread::drain(Take&& take, TakeHang&& take_hang) {
  const auto time = [](std::uint64_t word) { return TimePoint{Nanos{static_cast<Nanos::rep>(word)}}; };
  reports_.drain([&](std::span<const std::uint64_t> words) {
    if (words[0] == kHangBegan || words[0] == kHangEnded) {
      take_hang(Hang{time(words[2]), words[0] == kHangBegan});
    } else {
      take(record::Trigger{subchain_, words[0], time(words[1]), time(words[2])});
    }
  });
}

}  // namespace ctn::runtime
