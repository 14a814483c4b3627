#include "os/fake/faulty_os.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <system_error>
#include <utility>

namespace ctn::os {

Error refused() { return Error::environment("not permitted (on order of a test)", "order less"); }

// --- Orders ---

void FaultyOs::add(Call call, Order order) {
  assert(order.count > 0);
  const std::lock_guard lock(mutex_);
  orders_[call].push_back(std::move(order));
}

std::optional<FaultyOs::Order> FaultyOs::next(Call call) {
  const std::lock_guard lock(mutex_);
  const auto found = orders_.find(call);
  if (found == orders_.end() || found->second.empty()) return std::nullopt;
  Order order = found->second.front();
  if (--found->second.front().count == 0) found->second.pop_front();
  return order;
}

void FaultyOs::fail_next(Call call, int count, Error error) {
  assert(call != Call::kWait && call != Call::kSleepUntil);
  add(call, {count, std::move(error), false, Nanos{0}});
}

void FaultyOs::pass_next(Call call, int count) {
  assert(call == Call::kSpawn);
  add(call, {count, std::nullopt, false, Nanos{0}});
}

void FaultyOs::ignore_next(Call call, int count) {
  assert(call == Call::kSetLevel || call == Call::kSetAffinity);
  add(call, {count, std::nullopt, true, Nanos{0}});
}

void FaultyOs::delay_next(Call call, int count, Nanos late) {
  assert((call == Call::kWait || call == Call::kSleepUntil) && late > Nanos{0});
  add(call, {count, std::nullopt, false, late});
}

void FaultyOs::lose_thread(ThreadId thread) {
  const std::lock_guard lock(mutex_);
  lost_threads_.insert(thread);
}

void FaultyOs::lose_cpu(int cpu) {
  const std::lock_guard lock(mutex_);
  lost_cpus_.insert(cpu);
}

std::optional<Error> FaultyOs::lost(ThreadId thread) const {
  const std::lock_guard lock(mutex_);
  if (!lost_threads_.contains(thread)) return std::nullopt;
  return Error::environment(fmt::format("thread {} is gone (on order of a test)", static_cast<int>(thread)),
                            "order less");
}

std::optional<Error> FaultyOs::lost(const CpuSet& cpus) const {
  const std::lock_guard lock(mutex_);
  const auto gone = std::find_if(lost_cpus_.begin(), lost_cpus_.end(), [&](int cpu) { return cpus.contains(cpu); });
  if (gone == lost_cpus_.end()) return std::nullopt;
  return Error::environment(fmt::format("CPU {} is gone (on order of a test)", *gone), "order less");
}

// --- Calls ---

void FaultyOs::be_late(Call call) {
  if (const auto order = next(call)) inner_.sleep_until(inner_.now() + order->late);
}

void FaultyOs::wait_for_wake(const std::atomic<std::uint32_t>& word, std::uint32_t expected) {
  inner_.wait_for_wake(word, expected);
  be_late(Call::kWait);
}

WaitResult FaultyOs::wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, TimePoint deadline) {
  const WaitResult result = inner_.wait(word, expected, deadline);
  be_late(Call::kWait);
  return result;
}

void FaultyOs::sleep_until(TimePoint deadline) {
  inner_.sleep_until(deadline);
  be_late(Call::kSleepUntil);
}

Result<Nanos> FaultyOs::thread_cpu_time(ThreadId thread) {
  if (auto error = lost(thread)) return *error;
  if (const auto order = next(Call::kThreadCpuTime)) return order->error.value_or(refused());
  return inner_.thread_cpu_time(thread);
}

Result<std::vector<ThreadId>> FaultyOs::threads(ProcessId process) {
  if (const auto order = next(Call::kThreads)) return order->error.value_or(refused());
  Result<std::vector<ThreadId>> found = inner_.threads(process);
  const std::lock_guard lock(mutex_);
  if (found.ok()) std::erase_if(*found, [&](ThreadId thread) { return lost_threads_.contains(thread); });
  return found;
}

std::unique_ptr<Thread> FaultyOs::spawn(const std::string& name, std::function<void()> body) {
  const auto order = next(Call::kSpawn);
  if (order && order->error) throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
  return inner_.spawn(name, std::move(body));
}

Status FaultyOs::set_level(ThreadId thread, Level level) {
  if (auto error = lost(thread)) return *error;
  const auto order = next(Call::kSetLevel);
  if (!order) return inner_.set_level(thread, level);
  if (order->error) return *order->error;
  const Result<Level> found = inner_.level(thread);
  if (!found.ok()) return found.error();
  if (*found == level) return Done{};
  return Error::environment(fmt::format("set level {} for thread {}, but it is {} (on order of a test)",
                                        to_string(level), static_cast<int>(thread), to_string(*found)),
                            "order less");
}

void FaultyOs::shift_level(ThreadId thread, Level level) { static_cast<void>(set_level(thread, level)); }

Result<Level> FaultyOs::level(ThreadId thread) {
  if (auto error = lost(thread)) return *error;
  if (const auto order = next(Call::kLevel)) return order->error.value_or(refused());
  return inner_.level(thread);
}

Status FaultyOs::set_affinity(ThreadId thread, const CpuSet& cpus) {
  if (auto error = lost(thread)) return *error;
  if (auto error = lost(cpus)) return *error;
  const auto order = next(Call::kSetAffinity);
  if (!order) return inner_.set_affinity(thread, cpus);
  if (order->error) return *order->error;
  const Result<CpuSet> found = inner_.affinity(thread);
  if (!found.ok()) return found.error();
  if (*found == cpus) return Done{};
  return Error::environment(fmt::format("bound thread {} to CPUs {}, but it may use {} (on order of a test)",
                                        static_cast<int>(thread), to_string(cpus), to_string(*found)),
                            "order less");
}

Result<CpuSet> FaultyOs::affinity(ThreadId thread) {
  if (auto error = lost(thread)) return *error;
  if (const auto order = next(Call::kAffinity)) return order->error.value_or(refused());
  return inner_.affinity(thread);
}

Result<SavedScheduling> FaultyOs::save_scheduling(ThreadId thread) {
  if (auto error = lost(thread)) return *error;
  if (const auto order = next(Call::kSaveScheduling)) return order->error.value_or(refused());
  return inner_.save_scheduling(thread);
}

Status FaultyOs::restore_scheduling(const SavedScheduling& saved) {
  if (auto error = lost(saved.thread)) return *error;
  if (const auto order = next(Call::kRestoreScheduling)) return order->error.value_or(refused());
  return inner_.restore_scheduling(saved);
}

Result<std::unique_ptr<ReadyCpus>> FaultyOs::keep_cpus_ready() {
  if (const auto order = next(Call::kKeepCpusReady)) return order->error.value_or(refused());
  return inner_.keep_cpus_ready();
}

class FaultyOs::FaultyGuardian : public Guardian {
 public:
  FaultyGuardian(FaultyOs& os, std::unique_ptr<Guardian> inner) : os_(os), inner_(std::move(inner)) {}

  bool watch(const SavedScheduling& before) override {
    return !os_.lost(before.thread) && !os_.next(Call::kWatch) && inner_->watch(before);
  }
  void forget(ThreadId thread) override { inner_->forget(thread); }
  Status ensure_running() override {
    if (const auto order = os_.next(Call::kEnsureRunning)) return order->error.value_or(refused());
    return inner_->ensure_running();
  }
  int replaced() const override { return inner_->replaced(); }

 private:
  FaultyOs& os_;
  std::unique_ptr<Guardian> inner_;
};

Result<std::unique_ptr<Guardian>> FaultyOs::start_guardian() {
  if (const auto order = next(Call::kStartGuardian)) return order->error.value_or(refused());
  Result<std::unique_ptr<Guardian>> guardian = inner_.start_guardian();
  if (!guardian.ok()) return guardian;
  return std::unique_ptr<Guardian>(std::make_unique<FaultyGuardian>(*this, std::move(*guardian)));
}

Result<Topology> FaultyOs::topology() {
  if (const auto order = next(Call::kTopology)) return order->error.value_or(refused());
  Result<Topology> found = inner_.topology();
  if (!found.ok()) return found;
  const std::lock_guard lock(mutex_);
  for (Cpu& cpu : found->cpus) cpu.online = cpu.online && !lost_cpus_.contains(cpu.number);
  return found;
}

// As topology() has them, orders included.
Result<CpuSet> FaultyOs::online_cpus() {
  const Result<Topology> found = topology();
  if (!found.ok()) return found.error();
  return found->online();
}

}  // namespace ctn::os
