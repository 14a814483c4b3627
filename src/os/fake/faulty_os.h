// Any operating system, failing on order: for tests of what happens when the machine says no, or is late.
//
//   FaultyOs os(inner);
//   os.fail_next(Call::kSetLevel, 2, refused());   // the next two calls, then all is as `inner` again
//   os.ignore_next(Call::kSetLevel, 1);            // the system says yes and does nothing: read-back finds it
//   os.pass_next(Call::kSpawn, 2);                 // the next two calls are as `inner` has them; then the next order
//   os.delay_next(Call::kWait, 3, 5ms);            // the next three return 5 ms late
//   os.lose_thread(thread); os.lose_cpu(1);        // permanently
//
// Orders for one call are met in the order given, each as often as said; without any, everything passes through.
// Thread safety: as os.h, orders included.
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "os/fake/number_clock.h"
#include "os/os.h"

namespace ctn::os {

enum class Call {
  kThreadCpuTime,  // of another thread
  kWait,
  kSleepUntil,
  kThreads,
  kSpawn,  // throws std::system_error, as where there are too many threads; the error that was ordered is not told
  kSetLevel,
  kLevel,
  kSetAffinity,
  kAffinity,
  kSaveScheduling,
  kRestoreScheduling,
  kTopology,
  kKeepCpusReady,
  kStartGuardian,
  kWatch,  // of a Guardian: it returns false
  kEnsureRunning,
};

// What a system without the privilege answers.
Error refused();

class FaultyOs : public Os {
 public:
  // `inner` outlives this.
  explicit FaultyOs(Os& inner) : inner_(inner) {}

  // Precondition: a call that can fail (not kWait, not kSleepUntil); count > 0.
  void fail_next(Call call, int count, Error error = refused());
  // Precondition: kSpawn; count > 0.
  void pass_next(Call call, int count);
  // Precondition: kSetLevel or kSetAffinity; count > 0. The call leaves everything as it is, reads back, and so fails
  // unless what was asked is what was.
  void ignore_next(Call call, int count);
  // Precondition: kWait or kSleepUntil; count > 0; late > 0.
  void delay_next(Call call, int count, Nanos late);
  // From now on every call about the thread fails as if it had ended, and it is listed no more.
  void lose_thread(ThreadId thread);
  // From now on the CPU is offline in the topology, and affinities that name it are refused.
  void lose_cpu(int cpu);

  TimePoint now() override { return inner_.now(); }
  Nanos thread_cpu_time() override { return inner_.thread_cpu_time(); }
  Result<Nanos> thread_cpu_time(ThreadId thread) override;
  Result<std::unique_ptr<CpuClock>> cpu_clock(ThreadId thread) override { return NumberClock::make(*this, thread); }
  std::uint64_t times_blocked() override { return inner_.times_blocked(); }
  std::optional<Nanos> ready_time() override { return inner_.ready_time(); }
  std::optional<Nanos> ready_time(ThreadId thread) override {
    return lost(thread) ? std::nullopt : inner_.ready_time(thread);
  }
  WaitResult wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) override;
  void wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) override;
  void wake(const std::atomic<std::uint32_t>& word) override { inner_.wake(word); }
  void sleep_until(TimePoint deadline) override;
  ProcessId current_process() override { return inner_.current_process(); }
  ThreadId current_thread() override { return inner_.current_thread(); }
  ThreadId main_thread(ProcessId process) override { return inner_.main_thread(process); }
  Result<std::vector<ThreadId>> threads(ProcessId process) override;
  std::unique_ptr<Thread> spawn(const std::string& name, std::function<void()> body) override;
  std::string thread_name(ThreadId thread) override { return lost(thread) ? "" : inner_.thread_name(thread); }
  Status set_level(ThreadId thread, Level level) override;
  void shift_level(ThreadId thread, Level level) override;
  Result<Level> level(ThreadId thread) override;
  Status set_affinity(ThreadId thread, const CpuSet& cpus) override;
  Result<CpuSet> affinity(ThreadId thread) override;
  Result<SavedScheduling> save_scheduling(ThreadId thread) override;
  bool is_raised(const SavedScheduling& saved) const override { return inner_.is_raised(saved); }
  Status restore_scheduling(const SavedScheduling& saved) override;
  Result<Topology> topology() override;
  Result<CpuSet> online_cpus() override;
  RealTimeFacts real_time_facts() override { return inner_.real_time_facts(); }
  HostFacts host_facts() override { return inner_.host_facts(); }
  int current_cpu() override { return inner_.current_cpu(); }
  PowerState power_state(const CpuSet& cpus) override { return inner_.power_state(cpus); }
  std::map<int, Nanos> stolen_time() override { return inner_.stolen_time(); }
  Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready() override;
  Result<std::unique_ptr<Guardian>> start_guardian() override;

 private:
  class FaultyGuardian;
  struct Order {
    int count = 0;
    std::optional<Error> error;
    bool ignore = false;
    Nanos late{0};
  };

  void add(Call call, Order order);
  // The order that this call has to meet, if any; counts it as met.
  std::optional<Order> next(Call call);
  // Why a call about a thread fails, if it does.
  std::optional<Error> lost(ThreadId thread) const;
  std::optional<Error> lost(const CpuSet& cpus) const;
  void be_late(Call call);

  Os& inner_;
  mutable std::mutex mutex_;
  std::map<Call, std::deque<Order>> orders_;
  std::set<ThreadId> lost_threads_;
  std::set<int> lost_cpus_;
};

}  // namespace ctn::os
