// An operating system in virtual time, for tests: the same calls give the same order and the same times, always.
//
// Threads made by spawn() are real threads, but one at a time has the baton and runs; it gives the baton up in wait(),
// sleep_until(), burn() and join() alone. Next is who can run at the earliest time; of those the highest level; of
// those who was made first. When nobody can run now, time jumps to the earliest deadline. The thread that makes the
// FakeOs is its thread 1. Threads do not compete for CPUs: burn() takes as long as it is asked, at whatever level (the
// simulator is for that). When nobody can ever run again, or a million hand-overs pass without time going on, the
// program aborts and lists all threads, instead of hanging.
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

  // Precondition: the topology has a CPU that is online.
  explicit FakeOs(Topology topology = fake_topology(2));
  ~FakeOs() override;

  // Consumes virtual CPU time: the caller's CPU clock and the time both go on by `duration`.
  void burn(Nanos duration);

  // Levels above kOrdinary are refused, with facts.why_not, unless facts.permitted.
  void set_real_time_facts(RealTimeFacts facts);
  void set_host_facts(HostFacts facts);
  // As Linux does it: a thread all of whose CPUs are gone may use every CPU from then on, also when they come back.
  // Precondition: there is such a CPU, and it is not the last one online.
  void set_cpu_online(int cpu, bool online);
  std::vector<Change> changes() const;

  TimePoint now() override;
  Nanos thread_cpu_time() override;
  Result<Nanos> thread_cpu_time(ThreadId thread) override;
  WaitResult wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) override;
  void wake(const std::atomic<std::uint32_t>& word) override;
  void sleep_until(TimePoint deadline) override;
  ProcessId current_process() override;
  ThreadId current_thread() override;
  Result<std::vector<ThreadId>> threads(ProcessId process) override;
  // The new thread has the maker's CPUs; it runs when its turn comes, not before the maker gives up the baton.
  std::unique_ptr<Thread> spawn(const std::string& name, std::function<void()> body) override;
  Status set_level(ThreadId thread, Level level) override;
  void shift_level(ThreadId thread, Level level) override;
  Result<Level> level(ThreadId thread) override;
  Status set_affinity(ThreadId thread, const CpuSet& cpus) override;
  Result<CpuSet> affinity(ThreadId thread) override;
  Result<SavedScheduling> save_scheduling(ThreadId thread) override;
  Status restore_scheduling(ThreadId thread, const SavedScheduling& saved) override;
  Result<Topology> topology() override;
  RealTimeFacts real_time_facts() override;
  HostFacts host_facts() override;
  // What is held lowers ready_cpus_held() when it is let go.
  Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready() override;
  int ready_cpus_held() const { return ready_cpus_held_->load(); }

 private:
  struct Task;
  class Handle;
  using Lock = std::unique_lock<std::mutex>;

  Task& attach(std::string name);
  Task& self(const char* call);
  Task* find(ThreadId thread);
  // Gives the baton away; returns when it is back. The caller has set when, or on what, the task can run again.
  void give_up(Task& task, Lock& lock);
  void hand_over();
  Task* next_task();
  void block_until(Task& task, TimePoint wake_at, Lock& lock);
  void run(Task& task, const std::function<void()>& body);
  void join(Task& target);
  [[noreturn]] void die(const std::string& why) const;
  Status apply_level(Task& task, Level level);
  Status apply_affinity(Task& task, const CpuSet& cpus);
  CpuSet usable(const Task& task) const;

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Task>> tasks_;  // in the order of their numbers; ended ones stay
  std::map<std::thread::id, Task*> attached_;
  Task* running_ = nullptr;
  TimePoint now_{};
  int hand_overs_in_place_ = 0;  // since time last went on
  std::uint64_t yields_ = 0;
  Topology topology_;
  RealTimeFacts real_time_facts_{true, "", 0.05, "fair server"};
  HostFacts host_facts_;
  std::shared_ptr<std::atomic<int>> ready_cpus_held_ = std::make_shared<std::atomic<int>>(0);
  std::vector<Change> changes_;
};

}  // namespace ctn::os
