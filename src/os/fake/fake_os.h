// An operating system in virtual time, for tests: the same calls give the same order and the same times, always.
//
// Threads made by spawn() are real threads, but one at a time has the baton and runs; it gives the baton up in wait(),
// sleep_until(), burn() and join() alone. Next is the thread that can run at the earliest time; of several the one at
// the highest level; of those the one that was made first. When no task can run now, time jumps to the earliest
// deadline. The thread that makes the FakeOs is its thread 1. When no task can ever run again, or a million switches of
// threads pass without time going on, the program aborts and lists all threads, instead of hanging.
//
// Threads do not compete for CPUs at first: burn() takes as long as it is asked, at whatever level. After
// share_cpus(true) they do, by the rules in fake_cpus.h:
//   - burn() takes until the caller has had that much of a CPU that its affinity names, under its level.
//   - A thread that becomes runnable (new, woken, at its deadline) goes on once it gets a CPU, so never at an instant
//     at which a higher level keeps its CPUs busy. At one instant, deadlines come first, then levels. Threads that are
//     woken at the same instant stand in line in the order in which they were woken, those of one wake() or deadline by
//     age.
//   - Code between calls still takes no time. The thread that has the baton keeps it until it gives it up, even if its
//     own calls (waking a higher level, lowering or moving itself) cost it its CPU; burn(0) is how to give way to such.
//   - A wait or sleep whose deadline has passed puts the caller at the end of its level's line.
//
// Units: as os.h; time starts at 0. Thread safety: as os.h, but wait(), sleep_until(), burn(), spawn(), join() and
// current_thread() belong to threads of this FakeOs. Handles of threads are destroyed before the FakeOs, and that by
// thread 1.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "os/fake/fake_cpus.h"
#include "os/os.h"

namespace ctn::os {

// `count` CPUs of one package, all online, each a core of its own.
Topology fake_topology(int count);

class FakeOs : public Os {
 public:
  // What was done to a thread, in order; calls that changed nothing are not listed.
  struct Change {
    TimePoint at;
    ThreadId thread;
    std::optional<Level> level;
    std::optional<CpuSet> affinity;
    friend bool operator==(const Change&, const Change&) = default;
  };

  // One call of a Guardian that took effect.
  struct GuardianCall {
    TimePoint at;
    ThreadId thread;
    std::optional<SavedScheduling> before;  // none: forget()
    friend bool operator==(const GuardianCall&, const GuardianCall&) = default;
  };

  // Precondition: the topology has a CPU that is online.
  explicit FakeOs(Topology topology = fake_topology(2));
  ~FakeOs() override;

  // Consumes virtual CPU time: the caller's CPU clock goes on by `duration`, and so does the time, or by more where
  // CPUs are shared.
  void burn(Nanos duration);
  // Whether burning threads compete for CPUs. Precondition: the caller is the only thread that lives.
  void share_cpus(bool shared);
  // While CPUs are shared: which thread had which, from when to when, in the order in which they began; of those by
  // CPU. A stretch goes on while the same thread keeps CPU and level.
  std::vector<FakeCpus::Stretch> stretches() const;

  // Levels above kOrdinary are refused, with facts.why_not, unless facts.permitted.
  void set_real_time_facts(RealTimeFacts facts);
  // As Linux does it: a thread all of whose CPUs are gone may use every CPU from then on, also when they come back.
  // Precondition: there is such a CPU, and it is not the last one online.
  void set_cpu_online(int cpu, bool online);
  // The CPUs that a cpuset leaves to the process: its threads may use those of theirs that are in it, or where none is,
  // all of it; and what they had when it grows again. Precondition: one of them is online.
  void set_cpuset(CpuSet cpus);
  void set_power_state(PowerState state);
  // Whether ready_time() tells anything; at first it does.
  void set_tells_ready_time(bool tells);
  // From now on the thread counts as another, which began just now and has the number of one that has ended.
  void reuse_number(ThreadId thread);
  std::vector<Change> changes() const;
  // Does what the guardian would if the process were killed now; no thread is watched any more then.
  void restore_watched();
  // Another program ends the guardian: restore_watched() does nothing until ensure_running() or watch() has replaced
  // it.
  void end_guardian();
  // How many threads can be watched at once, 1024 at first.
  void set_guardian_capacity(std::size_t room);
  std::vector<ThreadId> watched() const;
  std::vector<GuardianCall> guardian_calls() const;

  TimePoint now() override;
  Nanos thread_cpu_time() override;
  Result<Nanos> thread_cpu_time(ThreadId thread) override;
  Result<std::unique_ptr<CpuClock>> cpu_clock(ThreadId thread) override;
  std::uint64_t times_blocked() override;
  std::optional<Nanos> ready_time() override;
  std::optional<Nanos> ready_time(ThreadId thread) override;
  WaitResult wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) override;
  void wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) override;
  void wake(const std::atomic<std::uint32_t>& word) override;
  void sleep_until(TimePoint deadline) override;
  ProcessId current_process() override;
  ThreadId current_thread() override;
  ThreadId main_thread(ProcessId /*process*/) override { return ThreadId{1}; }
  Result<std::vector<ThreadId>> threads(ProcessId process) override;
  // The new thread has the maker's CPUs; it runs when its turn comes, not before the maker gives up the baton.
  std::unique_ptr<Thread> spawn(const std::string& name, std::function<void()> body) override;
  std::string thread_name(ThreadId thread) override;
  Status set_level(ThreadId thread, Level level) override;
  void shift_level(ThreadId thread, Level level) override;
  Result<Level> level(ThreadId thread) override;
  Status set_affinity(ThreadId thread, const CpuSet& cpus) override;
  Result<CpuSet> affinity(ThreadId thread) override;
  Result<SavedScheduling> save_scheduling(ThreadId thread) override;
  bool is_raised(const SavedScheduling& saved) const override;
  Status restore_scheduling(const SavedScheduling& saved) override;
  Result<Topology> topology() override;
  Result<CpuSet> online_cpus() override;
  RealTimeFacts real_time_facts() override;
  HostFacts host_facts() override;
  // While CPUs are not shared, the first that the caller may use.
  int current_cpu() override;
  PowerState power_state(const CpuSet& cpus) override;
  std::map<int, Nanos> stolen_time() override;
  // The object lowers ready_cpus_held() when it is destroyed.
  Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready() override;
  int ready_cpus_held() const { return ready_cpus_held_->load(); }
  // Precondition: none lives yet.
  Result<std::unique_ptr<Guardian>> start_guardian() override;

 private:
  struct Task;
  class Handle;
  class FakeGuardian;
  using Lock = std::unique_lock<std::mutex>;

  Task& attach(std::string name);
  Task& self(const char* call);
  Task* find(ThreadId thread);
  Task* find(const SavedScheduling& saved);
  // Gives the baton away; returns when it is back. The caller has set when, or on what, the task can run again.
  void yield_baton(Task& task, Lock& lock);
  void pass_baton();
  // The task that runs next; time goes on until then. Null when none ever can.
  Task* next_by_time();
  Task* next_on_shared_cpus();
  void make_runnable(Task& task);
  void wake_due();
  TimePoint next_deadline() const;
  void let_pass(Nanos duration);
  std::string describe(const Task& task) const;
  void block_until(Task& task, TimePoint wake_at, Lock& lock);
  void run(Task& task, const std::function<void()>& body);
  void join(Task& target);
  [[noreturn]] void die(const std::string& why) const;
  Status apply_level(Task& task, Level level);
  Status apply_affinity(Task& task, const CpuSet& cpus);
  CpuSet usable(const Task& task) const;
  CpuSet usable_by_process() const;
  void narrow_tasks();

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Task>> tasks_;  // in the order of their numbers; ended ones stay
  std::map<std::thread::id, Task*> attached_;
  Task* running_ = nullptr;
  TimePoint now_{};
  int passes_in_place_ = 0;  // since time last went on
  std::uint64_t yields_ = 0;
  bool shares_cpus_ = false;
  FakeCpus cpus_;  // has a claim for each thread that can run, where CPUs are shared
  Topology topology_;
  std::optional<CpuSet> cpuset_;  // none: all CPUs
  RealTimeFacts real_time_facts_{true, "", 0.05, "fair server"};
  HostFacts host_facts_;
  PowerState power_state_;
  bool tells_ready_time_ = true;
  std::shared_ptr<std::atomic<int>> ready_cpus_held_ = std::make_shared<std::atomic<int>>(0);
  std::vector<Change> changes_;
  std::map<ThreadId, SavedScheduling> watched_;
  std::vector<GuardianCall> guardian_calls_;
  std::size_t guardian_capacity_ = 1024;
  bool guardian_started_ = false;
  bool guardian_running_ = false;
};

}  // namespace ctn::os
