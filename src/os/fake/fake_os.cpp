#include "os/fake/fake_os.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <cstdlib>
#include <tuple>
#include <utility>

namespace ctn::os {
namespace {

constexpr ProcessId kProcess{1000};
constexpr int kMaxHandOversInPlace = 1'000'000;

Error gone(const std::string& what, ThreadId thread) {
  return Error::environment(fmt::format("cannot {} thread {}: it is gone", what, static_cast<int>(thread)),
                            "threads that end while they are scheduled need no mending");
}

std::string show_time(TimePoint time) { return fmt::format("{:.6f} ms", to_millis(time.time_since_epoch()).count()); }

}  // namespace

struct FakeOs::Task {
  ThreadId id{};
  std::string name;
  bool ended = false;
  TimePoint wake_at{};        // can run from then on; kNever: someone must wake it
  std::uint64_t yielded = 0;  // not 0: it could have gone on; the least has been waiting longest
  const std::atomic<std::uint32_t>* word = nullptr;
  const Task* joining = nullptr;
  std::optional<TimePoint> burning_since;
  Nanos cpu_time{0};
  Level level = Level::kOrdinary;
  bool reset_on_fork = false;
  CpuSet cpus;  // as asked; those that are online count
  std::thread thread;
  std::condition_variable baton;

  std::string describe() const {
    const auto who = fmt::format("thread {} '{}' ({})", static_cast<int>(id), name, to_string(level));
    if (ended) return who + " has ended";
    if (word) return fmt::format("{} waits for a word that is {}", who, word->load());
    if (joining) return fmt::format("{} joins thread {}", who, static_cast<int>(joining->id));
    if (wake_at == kNever) return who + " sleeps for ever";
    return fmt::format("{} can run at {}", who, show_time(wake_at));
  }
};

class FakeOs::Handle : public Thread {
 public:
  Handle(FakeOs& os, Task& task) : os_(os), task_(task) {}
  ~Handle() override { Handle::join(); }
  void join() override {
    if (!std::exchange(joined_, true)) os_.join(task_);
  }

 private:
  FakeOs& os_;
  Task& task_;
  bool joined_ = false;
};

Topology fake_topology(int count) {
  Topology topology;
  for (int number = 0; number < count; ++number) {
    Cpu cpu;
    cpu.number = number;
    cpu.core = number;
    topology.cpus.push_back(cpu);
  }
  return topology;
}

FakeOs::FakeOs(Topology topology) : topology_(std::move(topology)) {
  assert(!topology_.online().empty());
  host_facts_.kernel = "fake";
  host_facts_.cpu_model = "virtual time";
  host_facts_.cpu_count = static_cast<int>(topology_.online().size());
  Task& first = attach("main");
  first.cpus = topology_.online();
  attached_[std::this_thread::get_id()] = &first;
  running_ = &first;
}

FakeOs::~FakeOs() {
  const Lock lock(mutex_);
  for (const auto& task : tasks_) {
    if (task->thread.joinable()) die("it is destroyed before the handle of " + task->describe());
  }
}

// ---- The kernel: who has the baton
// -----------------------------------------------------------------------------------

FakeOs::Task& FakeOs::attach(std::string name) {
  tasks_.push_back(std::make_unique<Task>());
  Task& task = *tasks_.back();
  task.id = ThreadId{static_cast<std::int32_t>(tasks_.size())};
  task.name = std::move(name);
  task.wake_at = now_;
  return task;
}

FakeOs::Task& FakeOs::self(const char* call) {
  const auto found = attached_.find(std::this_thread::get_id());
  if (found == attached_.end()) die(fmt::format("{} was called from a thread that spawn() did not make", call));
  return *found->second;
}

FakeOs::Task* FakeOs::find(ThreadId thread) {
  const auto index = static_cast<std::size_t>(thread) - 1;
  if (index >= tasks_.size() || tasks_[index]->ended) return nullptr;
  return tasks_[index].get();
}

FakeOs::Task* FakeOs::next_task() {
  const auto rank = [](const Task& task) {
    return std::tuple(task.wake_at, -static_cast<int>(task.level), task.yielded, task.id);
  };
  Task* next = nullptr;
  for (const auto& task : tasks_) {
    if (task->ended || task->wake_at == kNever) continue;
    if (!next || rank(*task) < rank(*next)) next = task.get();
  }
  return next;
}

void FakeOs::hand_over() {
  Task* const next = next_task();
  if (!next) die("deadlock: no thread can run, and none has a deadline");
  hand_overs_in_place_ = next->wake_at > now_ ? 0 : hand_overs_in_place_ + 1;
  if (hand_overs_in_place_ > kMaxHandOversInPlace) die("livelock: threads run without time going on");
  now_ = std::max(now_, next->wake_at);
  running_ = next;
  next->baton.notify_one();
}

void FakeOs::give_up(Task& task, Lock& lock) {
  hand_over();
  task.baton.wait(lock, [&] { return running_ == &task; });
}

void FakeOs::block_until(Task& task, TimePoint wake_at, Lock& lock) {
  task.wake_at = std::max(wake_at, now_);
  task.yielded = wake_at > now_ ? 0 : ++yields_;
  give_up(task, lock);
}

void FakeOs::run(Task& task, const std::function<void()>& body) {
  {
    Lock lock(mutex_);
    attached_[std::this_thread::get_id()] = &task;
    task.baton.wait(lock, [&] { return running_ == &task; });
  }
  body();
  const Lock lock(mutex_);
  task.ended = true;
  attached_.erase(std::this_thread::get_id());
  for (const auto& other : tasks_) {
    if (other->joining == &task) other->wake_at = now_;
  }
  hand_over();
}

void FakeOs::join(Task& target) {
  {
    Lock lock(mutex_);
    Task& task = self("join");
    task.joining = &target;
    while (!target.ended) block_until(task, kNever, lock);
    task.joining = nullptr;
  }
  target.thread.join();
}

void FakeOs::die(const std::string& why) const {
  std::string message = fmt::format("FakeOs at {}: {}\n", show_time(now_), why);
  for (const auto& task : tasks_) message += fmt::format("  {}\n", task->describe());
  std::fputs(message.c_str(), stderr);
  std::abort();
}

// ---- Time, waiting, threads
// ------------------------------------------------------------------------------------------

TimePoint FakeOs::now() {
  const Lock lock(mutex_);
  return now_;
}

void FakeOs::burn(Nanos duration) {
  assert(duration >= Nanos{0});
  Lock lock(mutex_);
  Task& task = self("burn");
  task.burning_since = now_;
  block_until(task, now_ + duration, lock);
  task.burning_since.reset();
  task.cpu_time += duration;
}

Nanos FakeOs::thread_cpu_time() {
  const Lock lock(mutex_);
  return self("thread_cpu_time").cpu_time;
}

Result<Nanos> FakeOs::thread_cpu_time(ThreadId thread) {
  const Lock lock(mutex_);
  const Task* const task = find(thread);
  if (!task) return gone("read the CPU time of", thread);
  return task->cpu_time + (task->burning_since ? now_ - *task->burning_since : Nanos{0});
}

WaitResult FakeOs::wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) {
  Lock lock(mutex_);
  Task& task = self("wait");
  while (word.load() == expected) {
    task.word = &word;
    block_until(task, deadline, lock);  // also when the deadline has passed: who polls must let others run
    task.word = nullptr;
    if (now_ >= deadline) break;
  }
  return word.load() == expected ? WaitResult::kTimedOut : WaitResult::kChanged;
}

void FakeOs::wake(const std::atomic<std::uint32_t>& word) {
  const Lock lock(mutex_);
  for (const auto& task : tasks_) {
    if (task->word == &word) task->wake_at = now_;
  }
}

void FakeOs::sleep_until(TimePoint deadline) {
  Lock lock(mutex_);
  block_until(self("sleep_until"), deadline, lock);
}

ProcessId FakeOs::current_process() { return kProcess; }

ThreadId FakeOs::current_thread() {
  const Lock lock(mutex_);
  return self("current_thread").id;
}

Result<std::vector<ThreadId>> FakeOs::threads(ProcessId process) {
  const Lock lock(mutex_);
  if (process != kProcess) {
    return Error::environment(
        fmt::format("cannot list the threads of process {}: it is gone", static_cast<int>(process)), "start it again");
  }
  std::vector<ThreadId> live;
  for (const auto& task : tasks_) {
    if (!task->ended) live.push_back(task->id);
  }
  return live;
}

std::unique_ptr<Thread> FakeOs::spawn(const std::string& name, std::function<void()> body) {
  const Lock lock(mutex_);
  const CpuSet cpus = self("spawn").cpus;
  Task& task = attach(name.substr(0, 15));
  task.cpus = cpus;
  task.thread = std::thread([this, &task, body = std::move(body)] { run(task, body); });
  return std::make_unique<Handle>(*this, task);
}

// ---- Levels, CPUs, facts
// ---------------------------------------------------------------------------------------------

Status FakeOs::apply_level(Task& task, Level level) {
  if (level != Level::kOrdinary && !real_time_facts_.permitted) {
    return Error::environment(
        fmt::format("cannot set level {} for thread {}: not permitted", to_string(level), static_cast<int>(task.id)),
        real_time_facts_.why_not);
  }
  task.level = level;
  changes_.push_back({now_, task.id, level, std::nullopt});
  return Done{};
}

Status FakeOs::set_level(ThreadId thread, Level level) {
  const Lock lock(mutex_);
  Task* const task = find(thread);
  if (!task) return gone("set the level of", thread);
  Status set = apply_level(*task, level);
  if (set.ok()) task->reset_on_fork = true;
  return set;
}

void FakeOs::shift_level(ThreadId thread, Level level) { static_cast<void>(set_level(thread, level)); }

Result<Level> FakeOs::level(ThreadId thread) {
  const Lock lock(mutex_);
  const Task* const task = find(thread);
  if (!task) return gone("read the level of", thread);
  return task->level;
}

CpuSet FakeOs::usable(const Task& task) const {
  std::vector<int> numbers;
  for (const int cpu : topology_.online().cpus()) {
    if (task.cpus.contains(cpu)) numbers.push_back(cpu);
  }
  return CpuSet(std::move(numbers));
}

Status FakeOs::apply_affinity(Task& task, const CpuSet& cpus) {
  CpuSet before = std::exchange(task.cpus, cpus);
  if (usable(task).empty()) {
    task.cpus = std::move(before);
  } else {
    changes_.push_back({now_, task.id, std::nullopt, usable(task)});
  }
  const CpuSet found = usable(task);
  if (found == cpus) return Done{};
  return Error::environment(fmt::format("cannot bind to CPUs {} thread {}: it may use CPUs {}", to_string(cpus),
                                        static_cast<int>(task.id), to_string(found)),
                            fmt::format("name CPUs that are online ({})", to_string(topology_.online())));
}

Status FakeOs::set_affinity(ThreadId thread, const CpuSet& cpus) {
  if (cpus.empty()) return Error::caller("a thread cannot be bound to no CPU", "name at least one CPU");
  if (cpus.cpus().front() < 0) {
    return Error::caller(fmt::format("{} is no CPU number", cpus.cpus().front()), "CPU numbers start at 0");
  }
  const Lock lock(mutex_);
  Task* const task = find(thread);
  return task ? apply_affinity(*task, cpus) : Status(gone("bind", thread));
}

Result<CpuSet> FakeOs::affinity(ThreadId thread) {
  const Lock lock(mutex_);
  const Task* const task = find(thread);
  if (!task) return gone("read the CPUs of", thread);
  return usable(*task);
}

Result<SavedScheduling> FakeOs::save_scheduling(ThreadId thread) {
  const Lock lock(mutex_);
  const Task* const task = find(thread);
  if (!task) return gone("read the scheduling of", thread);
  return SavedScheduling{static_cast<int>(task->level), 0, 0, task->reset_on_fork, usable(*task)};
}

Status FakeOs::restore_scheduling(ThreadId thread, const SavedScheduling& saved) {
  const Lock lock(mutex_);
  Task* const task = find(thread);
  if (!task) return gone("restore the scheduling of", thread);
  const auto level = static_cast<Level>(saved.policy);
  if (task->level != level) {
    Status set = apply_level(*task, level);
    if (!set.ok()) return set;
  }
  task->reset_on_fork = saved.reset_on_fork;
  if (usable(*task) == saved.affinity) return Done{};
  // CPUs that went away meanwhile are no error; when all did, every CPU is allowed.
  static_cast<void>(apply_affinity(*task, saved.affinity));
  const bool none_left = task->cpus != saved.affinity;
  return none_left ? apply_affinity(*task, topology_.online()) : Status(Done{});
}

void FakeOs::set_cpu_online(int cpu, bool online) {
  const Lock lock(mutex_);
  const auto found = std::find_if(topology_.cpus.begin(), topology_.cpus.end(),
                                  [&](const Cpu& candidate) { return candidate.number == cpu; });
  assert(found != topology_.cpus.end());
  found->online = online;
  assert(!topology_.online().empty());
  host_facts_.cpu_count = static_cast<int>(topology_.online().size());
  std::vector<int> all;
  for (const Cpu& known : topology_.cpus) all.push_back(known.number);
  for (const auto& task : tasks_) {
    if (task->ended || !usable(*task).empty()) continue;
    task->cpus = CpuSet(all);
    changes_.push_back({now_, task->id, std::nullopt, usable(*task)});
  }
}

void FakeOs::set_real_time_facts(RealTimeFacts facts) {
  const Lock lock(mutex_);
  real_time_facts_ = std::move(facts);
}

void FakeOs::set_host_facts(HostFacts facts) {
  const Lock lock(mutex_);
  host_facts_ = std::move(facts);
}

std::vector<FakeOs::Change> FakeOs::changes() const {
  const Lock lock(mutex_);
  return changes_;
}

Result<Topology> FakeOs::topology() {
  const Lock lock(mutex_);
  return topology_;
}

RealTimeFacts FakeOs::real_time_facts() {
  const Lock lock(mutex_);
  return real_time_facts_;
}

Result<std::unique_ptr<ReadyCpus>> FakeOs::keep_cpus_ready() {
  struct Held : ReadyCpus {
    explicit Held(std::shared_ptr<std::atomic<int>> held) : count(std::move(held)) { ++*count; }
    ~Held() override { --*count; }
    std::shared_ptr<std::atomic<int>> count;
  };
  return std::unique_ptr<ReadyCpus>(std::make_unique<Held>(ready_cpus_held_));
}

HostFacts FakeOs::host_facts() {
  const Lock lock(mutex_);
  return host_facts_;
}

}  // namespace ctn::os
