#include "os/fake/fake_os.h"

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <cstdlib>
#include <tuple>
#include <utility>

#include "os/fake/fake_task.h"
#include "os/fake/number_clock.h"

namespace ctn::os {
namespace {

constexpr ProcessId kProcess{1000};
constexpr int kMaxPassesInPlace = 1'000'000;

}  // namespace

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

// --- The kernel: which thread has the baton ---

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

void FakeOs::make_runnable(Task& task) {
  task.wake_at = now_;
  if (shares_cpus_ && !cpus_.has(task.id)) cpus_.add(task.id, task.level, usable(task));
}

FakeOs::Task* FakeOs::next_by_time() {
  const auto rank = [](const Task& task) {
    return std::tuple(task.wake_at, -static_cast<int>(task.level), task.yielded, task.id);
  };
  Task* next = nullptr;
  for (const auto& task : tasks_) {
    if (task->ended || task->wake_at == kNever) continue;
    if (!next || rank(*task) < rank(*next)) next = task.get();
  }
  if (next) now_ = std::max(now_, next->wake_at);
  return next;
}

void FakeOs::wake_due() {
  for (const auto& task : tasks_) {
    if (!task->ended && !cpus_.has(task->id) && task->wake_at <= now_) make_runnable(*task);
  }
}

TimePoint FakeOs::next_deadline() const {
  TimePoint next = kNever;
  for (const auto& task : tasks_) {
    if (!task->ended && !cpus_.has(task->id)) next = std::min(next, task->wake_at);
  }
  return next;
}

void FakeOs::let_pass(Nanos duration) {
  for (const ThreadId waiting : cpus_.waiting()) find(waiting)->ready_time += duration;
  for (const ThreadId served : cpus_.pass(now_, duration)) find(served)->cpu_time += duration;
  now_ += duration;
}

FakeOs::Task* FakeOs::next_on_shared_cpus() {
  while (true) {
    wake_due();
    cpus_.assign();
    if (const auto ready = cpus_.ready()) return find(*ready);
    const TimePoint deadline = next_deadline();
    const auto event = cpus_.next_event();
    if (!event && deadline == kNever) return nullptr;
    let_pass(event ? std::min(*event, deadline - now_) : deadline - now_);
  }
}

void FakeOs::pass_baton() {
  const TimePoint before = now_;
  Task* const next = shares_cpus_ ? next_on_shared_cpus() : next_by_time();
  if (!next) die("deadlock: no thread can run, and none has a deadline");
  passes_in_place_ = now_ > before ? 0 : passes_in_place_ + 1;
  if (passes_in_place_ > kMaxPassesInPlace) die("livelock: threads run without time going on");
  running_ = next;
  next->baton.notify_one();
}

void FakeOs::yield_baton(Task& task, Lock& lock) {
  pass_baton();
  task.baton.wait(lock, [&] { return running_ == &task; });
}

void FakeOs::block_until(Task& task, TimePoint wake_at, Lock& lock) {
  task.wake_at = std::max(wake_at, now_);
  if (wake_at > now_ && !task.burning_since) ++task.times_blocked;
  task.yielded = wake_at > now_ ? 0 : ++yields_;
  if (shares_cpus_ && wake_at > now_) cpus_.remove(task.id);
  if (shares_cpus_ && wake_at <= now_) cpus_.to_the_end(task.id);
  yield_baton(task, lock);
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
  cpus_.remove(task.id);
  attached_.erase(std::this_thread::get_id());
  for (const auto& other : tasks_) {
    if (other->joining == &task) make_runnable(*other);
  }
  pass_baton();
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

std::string FakeOs::describe(const Task& task) const {
  if (!cpus_.has(task.id)) return task.describe();
  return fmt::format("{} {}", task.who(), cpus_.describe(task.id));
}

void FakeOs::die(const std::string& why) const {
  std::string message = fmt::format("FakeOs at {}: {}\n", show_time(now_), why);
  for (const auto& task : tasks_) message += fmt::format("  {}\n", describe(*task));
  std::fputs(message.c_str(), stderr);
  std::abort();
}

// --- Time, waiting, threads ---

TimePoint FakeOs::now() {
  const Lock lock(mutex_);
  return now_;
}

void FakeOs::burn(Nanos duration) {
  assert(duration >= Nanos{0});
  Lock lock(mutex_);
  Task& task = self("burn");
  if (shares_cpus_) {
    cpus_.consume(task.id, duration);
    return yield_baton(task, lock);
  }
  task.burning_since = now_;
  block_until(task, now_ + duration, lock);
  task.burning_since.reset();
  task.cpu_time += duration;
}

void FakeOs::share_cpus(bool shared) {
  const Lock lock(mutex_);
  Task& task = self("share_cpus");
  const bool alone = std::all_of(tasks_.begin(), tasks_.end(),
                                 [&](const auto& other) { return other.get() == &task || other->ended; });
  if (!alone) die("share_cpus was called while other threads live");
  shares_cpus_ = shared;
  cpus_.remove(task.id);
  make_runnable(task);
}

std::vector<FakeCpus::Stretch> FakeOs::stretches() const {
  const Lock lock(mutex_);
  return cpus_.stretches();
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

Result<std::unique_ptr<CpuClock>> FakeOs::cpu_clock(ThreadId thread) { return NumberClock::make(*this, thread); }

std::uint64_t FakeOs::times_blocked() {
  const Lock lock(mutex_);
  return self("times_blocked").times_blocked;
}

std::optional<Nanos> FakeOs::ready_time() {
  const Lock lock(mutex_);
  return tells_ready_time_ ? std::optional(self("ready_time").ready_time) : std::nullopt;
}

std::optional<Nanos> FakeOs::ready_time(ThreadId thread) {
  const Lock lock(mutex_);
  const Task* const task = find(thread);
  return task && tells_ready_time_ ? std::optional(task->ready_time) : std::nullopt;
}

std::string FakeOs::thread_name(ThreadId thread) {
  const Lock lock(mutex_);
  const Task* const task = find(thread);
  return task ? task->name : std::string();
}

WaitResult FakeOs::wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) {
  Lock lock(mutex_);
  Task& task = self("wait");
  while (word.load() == expected) {
    task.word = &word;
    block_until(task, deadline, lock);  // also when the deadline has passed: a thread that polls must let others run
    task.word = nullptr;
    if (now_ >= deadline) break;
  }
  return word.load() == expected ? WaitResult::kTimedOut : WaitResult::kChanged;
}

void FakeOs::wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) {
  Lock lock(mutex_);
  Task& task = self("wait_for_wake");
  if (word.load() != expected) return;
  task.word = &word;
  block_until(task, kNever, lock);
  task.word = nullptr;
}

void FakeOs::wake(const std::atomic<std::uint32_t>& word) {
  const Lock lock(mutex_);
  for (const auto& task : tasks_) {
    if (task->word == &word) make_runnable(*task);
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
  make_runnable(task);
  task.thread = std::thread([this, &task, body = std::move(body)] { run(task, body); });
  return std::make_unique<Handle>(*this, task);
}

}  // namespace ctn::os
