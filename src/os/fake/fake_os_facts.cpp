// FakeOs: levels, CPUs, facts.
#include <algorithm>
#include <cassert>
#include <utility>

#include "os/fake/fake_os.h"
#include "os/fake/fake_task.h"

namespace ctn::os {

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

Status FakeOs::apply_level(Task& task, Level level) {
  if (level != Level::kOrdinary && !real_time_facts_.permitted) {
    return Error::environment(
        fmt::format("cannot set level {} for thread {}: not permitted", to_string(level), static_cast<int>(task.id)),
        real_time_facts_.why_not);
  }
  task.level = level;
  cpus_.set_level(task.id, level);
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

CpuSet FakeOs::usable_by_process() const { return cpuset_ ? common(topology_.online(), *cpuset_) : topology_.online(); }

CpuSet FakeOs::usable(const Task& task) const { return common(usable_by_process(), task.cpus); }

Status FakeOs::apply_affinity(Task& task, const CpuSet& cpus) {
  CpuSet before = std::exchange(task.cpus, cpus);
  if (usable(task).empty()) {
    task.cpus = std::move(before);
  } else {
    cpus_.set_usable(task.id, usable(task));
    changes_.push_back({now_, task.id, std::nullopt, usable(task)});
  }
  const CpuSet found = usable(task);
  if (found == cpus) return Done{};
  return Error::environment(fmt::format("cannot bind to CPUs {} thread {}: it may use CPUs {}", to_string(cpus),
                                        static_cast<int>(task.id), to_string(found)),
                            fmt::format("name CPUs that are online ({})", to_string(topology_.online())));
}

Status FakeOs::set_affinity(ThreadId thread, const CpuSet& cpus) {
  if (cpus.empty()) return Error::caller("a thread cannot be pinned to no CPU", "name at least one CPU");
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
  return SavedScheduling{thread,       task->started, static_cast<int>(task->level), 0, 0, task->reset_on_fork,
                         usable(*task)};
}

bool FakeOs::is_raised(const SavedScheduling& saved) const {
  return static_cast<Level>(saved.policy) != Level::kOrdinary && saved.reset_on_fork;
}

FakeOs::Task* FakeOs::find(const SavedScheduling& saved) {
  Task* const task = find(saved.thread);
  return task && task->started == saved.started ? task : nullptr;
}

void FakeOs::reuse_number(ThreadId thread) {
  const Lock lock(mutex_);
  Task* const task = find(thread);
  assert(task);
  ++task->started;
}

Status FakeOs::restore_scheduling(const SavedScheduling& saved) {
  const Lock lock(mutex_);
  Task* const task = find(saved);
  if (!task) return gone("restore the scheduling of", saved.thread);
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
  return none_left ? apply_affinity(*task, usable_by_process()) : Status(Done{});
}

void FakeOs::set_cpu_online(int cpu, bool online) {
  const Lock lock(mutex_);
  const auto found = std::find_if(topology_.cpus.begin(), topology_.cpus.end(),
                                  [&](const Cpu& candidate) { return candidate.number == cpu; });
  assert(found != topology_.cpus.end());
  found->online = online;
  host_facts_.cpu_count = static_cast<int>(topology_.online().size());
  narrow_tasks();
}

void FakeOs::set_cpuset(CpuSet cpus) {
  const Lock lock(mutex_);
  cpuset_ = std::move(cpus);
  narrow_tasks();
}

void FakeOs::narrow_tasks() {
  assert(!usable_by_process().empty());
  std::vector<int> all;
  for (const Cpu& known : topology_.cpus) all.push_back(known.number);
  for (const auto& task : tasks_) {
    if (task->ended) continue;
    if (usable(*task).empty()) {
      task->cpus = CpuSet(all);
      changes_.push_back({now_, task->id, std::nullopt, usable(*task)});
    }
    cpus_.set_usable(task->id, usable(*task));
  }
}

void FakeOs::set_real_time_facts(RealTimeFacts facts) {
  const Lock lock(mutex_);
  real_time_facts_ = std::move(facts);
}

std::vector<FakeOs::Change> FakeOs::changes() const {
  const Lock lock(mutex_);
  return changes_;
}

Result<Topology> FakeOs::topology() {
  const Lock lock(mutex_);
  return topology_;
}

Result<CpuSet> FakeOs::online_cpus() {
  const Lock lock(mutex_);
  return topology_.online();
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

void FakeOs::set_tells_ready_time(bool tells) {
  const Lock lock(mutex_);
  tells_ready_time_ = tells;
}

void FakeOs::set_power_state(PowerState state) {
  const Lock lock(mutex_);
  power_state_ = std::move(state);
}

int FakeOs::current_cpu() {
  const Lock lock(mutex_);
  const Task& task = self("current_cpu");
  return cpus_.cpu_of(task.id).value_or(usable(task).cpus().front());
}

PowerState FakeOs::power_state(const CpuSet& cpus) {
  const Lock lock(mutex_);
  PowerState state = power_state_;
  std::erase_if(state.cpus, [&](const PowerState::Cpu& cpu) { return !cpus.contains(cpu.number); });
  return state;
}

std::map<int, Nanos> FakeOs::stolen_time() { return {}; }

}  // namespace ctn::os
