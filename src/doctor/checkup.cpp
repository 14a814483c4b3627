#include "doctor/checkup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "os/scheduling_guard.h"

namespace ctn::doctor {
namespace {

constexpr Nanos kPeriod{1'000'000};
constexpr int kRealTimeCount = 200;
constexpr int kOrdinaryCount = 100;

// Where the kernel keeps most of the CPU from real-time threads, measuring at their level could take for ever.
constexpr double kMaxCpuShare = 0.5;

Status prepare(os::Os& os, int cpu, os::Level level) {
  const Status pinned = os.set_affinity(os.current_thread(), os::CpuSet{cpu});
  if (!pinned.ok() || level == os::Level::kOrdinary) return pinned;
  return os.set_level(os.current_thread(), level);
}

void sleep_and_measure(os::Os& os, os::Level level, int count, Nanos period, WakeUps& found) {
  os::SchedulingGuard guard(os, os.current_thread());
  Status ready = guard.status();
  if (ready.ok()) ready = prepare(os, found.cpu, level);
  if (!ready.ok()) {
    found.refused = ready.error();
    return;
  }
  for (int i = 0; i < count; ++i) {
    const TimePoint due = os.now() + period;  // again each time: a long stall counts once
    os.sleep_until(due);
    found.lateness.push_back(std::max(os.now() - due, Nanos{0}));
  }
  std::sort(found.lateness.begin(), found.lateness.end());
}

Status known(const os::Topology& topology, const os::CpuSet& cpus) {
  std::vector<int> all;
  for (const os::Cpu& cpu : topology.cpus) all.push_back(cpu.number);
  const os::CpuSet there(std::move(all));
  for (const int cpu : cpus.cpus()) {
    if (there.contains(cpu)) continue;
    return Error::caller(fmt::format("this machine has no CPU {}", cpu),
                         fmt::format("it has CPUs {}", to_string(there)));
  }
  return Done{};
}

void try_to_keep_ready(os::Os& os, Observed& observed) {
  const Result<std::unique_ptr<os::ReadyCpus>> kept = os.keep_cpus_ready();
  if (!kept.ok()) observed.not_ready = kept.error();
  observed.keeps_ready = kept.ok() && kept.value() != nullptr;
}

void measure(os::Os& os, Observed& observed) {
  const bool real_time = observed.real_time.permitted && observed.real_time.reserved < kMaxCpuShare;
  observed.level = real_time ? os::Level::kDispatcher : os::Level::kOrdinary;
  const TimePoint begin = os.now();
  observed.wake_ups = measure_wake_ups(os, observed.cpus, observed.level, kRealTimeCount, kPeriod);
  observed.ordinary = measure_wake_ups(os, observed.cpus, os::Level::kOrdinary, kOrdinaryCount, kPeriod);
  observed.measured = os.now() - begin;
  observed.stolen = std::max(os.host_facts().steal - observed.host.steal, Nanos{0});
}

}  // namespace

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kNote:
      return "note";
    case Verdict::kWarning:
      return "warning";
    case Verdict::kProblem:
      break;
  }
  return "problem";
}

Verdict worst(const std::vector<Finding>& findings) {
  Verdict worst = Verdict::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.verdict);
  return worst;
}

Nanos WakeUps::percentile(double percent) const {
  if (lateness.empty()) return Nanos{0};
  const double rank = std::ceil(percent / 100.0 * static_cast<double>(lateness.size()));
  return lateness[std::clamp(static_cast<std::size_t>(rank), std::size_t{1}, lateness.size()) - 1];
}

std::vector<WakeUps> measure_wake_ups(os::Os& os, const os::CpuSet& cpus, os::Level level, int count, Nanos period) {
  std::vector<WakeUps> found(cpus.size());
  std::vector<std::unique_ptr<os::Thread>> threads;
  for (std::size_t i = 0; i < found.size(); ++i) {
    WakeUps& own = found[i];
    own.cpu = cpus.cpus()[i];
    own.lateness.reserve(static_cast<std::size_t>(count));
    threads.push_back(os.spawn(
        "catan-doctor", [&os, &own, level, count, period] { sleep_and_measure(os, level, count, period, own); }));
  }
  threads.clear();  // joins
  return found;
}

WakeUps together(const std::vector<WakeUps>& each) {
  WakeUps all;
  if (!each.empty()) all.cpu = each.front().cpu;
  for (const WakeUps& one : each) all.lateness.insert(all.lateness.end(), one.lateness.begin(), one.lateness.end());
  std::sort(all.lateness.begin(), all.lateness.end());
  return all;
}

Result<Observed> observe(os::Os& os, const os::CpuSet& cpus) {
  Observed observed;
  Result<os::Topology> topology = os.topology();
  if (!topology.ok()) return topology.error();
  observed.topology = std::move(*topology);
  if (const Status there = known(observed.topology, cpus); !there.ok()) return there.error();
  const Result<os::CpuSet> allowed = os.affinity(os.current_thread());
  if (!allowed.ok()) return allowed.error();
  observed.allowed = *allowed;
  observed.cpus = cpus.empty() ? observed.allowed : cpus;
  observed.real_time = os.real_time_facts();
  observed.host = os.host_facts();
  try_to_keep_ready(os, observed);
  measure(os, observed);
  return observed;
}

}  // namespace ctn::doctor
