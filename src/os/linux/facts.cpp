#include "os/linux/facts.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <set>
#include <sstream>
#include <utility>

#include "os/linux/privilege.h"
#include "os/linux/topology.h"

namespace ctn::os {
namespace {

constexpr double kDefaultReserve = 0.05;  // of both mechanisms: 50 ms in 1 s

using KernelVersion = std::pair<int, int>;  // major, minor
constexpr KernelVersion kFirstWithFairServer{6, 12};

std::string kernel_release(const LinuxRoots& roots) {
  if (auto release = read_line(roots.procfs + "/sys/kernel/osrelease")) return *release;
  utsname names{};
  return ::uname(&names) == 0 ? names.release : "";
}

std::optional<KernelVersion> kernel_version(const LinuxRoots& roots) {
  std::istringstream release(kernel_release(roots));
  KernelVersion version;
  char dot = 0;
  if (!(release >> version.first >> dot >> version.second) || dot != '.') return std::nullopt;
  return version;
}

double unused_fraction(std::int64_t runtime, std::int64_t period) {
  return std::clamp(static_cast<double>(period - runtime) / static_cast<double>(period), 0.0, 1.0);
}

// The largest of all CPUs, where debugfs can be read.
std::optional<Reserve> read_fair_server(const LinuxRoots& roots) {
  const std::string folder = roots.sysfs + "/kernel/debug/sched/fair_server";
  const std::vector<int> cpus = numbered_entries(folder, "cpu").value_or(std::vector<int>{});
  std::optional<Reserve> largest;
  for (const int cpu : cpus) {
    const auto runtime = read_integer(fmt::format("{}/cpu{}/runtime", folder, cpu));
    const auto period = read_integer(fmt::format("{}/cpu{}/period", folder, cpu));
    if (!runtime || !period || *runtime < 0 || *period <= 0) continue;
    const double fraction = std::min(1.0, static_cast<double>(*runtime) / static_cast<double>(*period));
    if (!largest || fraction > largest->fraction) largest = Reserve{fraction, "fair server"};
  }
  return largest;
}

Reserve fair_server(const LinuxRoots& roots) {
  const auto version = kernel_version(roots);
  if (auto found = read_fair_server(roots)) return *found;
  // A version that cannot be read is taken for a new one: a reserve that is not there costs little, the reverse a lot.
  if (version && *version < kFirstWithFairServer) return {};
  return {kDefaultReserve, "fair server (assumed default)"};
}

Reserve throttling(const LinuxRoots& roots) {
  const auto runtime = read_integer(roots.procfs + "/sys/kernel/sched_rt_runtime_us");
  const auto period = read_integer(roots.procfs + "/sys/kernel/sched_rt_period_us");
  if (!runtime || !period || *period <= 0) return {kDefaultReserve, "throttling (assumed default)"};
  if (*runtime < 0) return {};
  return {unused_fraction(*runtime, *period), "throttling"};
}

// A cgroup with no time at all has no real-time threads to reserve anything from: `permitted` says so.
Reserve cgroup_throttling(const LinuxRoots& roots) {
  const auto cgroup = real_time_cgroup(roots);
  if (!cgroup || cgroup->runtime_us <= 0) return {};
  return {unused_fraction(cgroup->runtime_us, cgroup->period_us), "throttling"};
}

std::string cpu_model(const LinuxRoots& roots) {
  // x86 says "model name"; ARM boards name themselves at the end of cpuinfo or in the device tree.
  const std::string text = read_text(roots.procfs + "/cpuinfo").value_or("");
  for (const char* key : {"model name", "Model", "Hardware", "cpu model", "cpu"}) {
    if (auto model = find_value(text, key)) return *model;
  }
  return read_line(roots.sysfs + "/firmware/devicetree/base/model").value_or("");
}

// All governors in use, "performance,powersave" where CPUs differ.
std::string governors(const LinuxRoots& roots) {
  const std::string folder = roots.sysfs + "/devices/system/cpu";
  std::set<std::string> names;
  for (const int cpu : numbered_entries(folder, "cpu").value_or(std::vector<int>{})) {
    if (auto name = read_line(fmt::format("{}/cpu{}/cpufreq/scaling_governor", folder, cpu))) names.insert(*name);
  }
  return fmt::format("{}", fmt::join(names, ","));
}

// "cpu user nice system idle iowait irq softirq steal ...", in units of 1/USER_HZ second.
Nanos steal_time(const LinuxRoots& roots) {
  std::istringstream line(read_line(roots.procfs + "/stat").value_or(""));
  std::string name;
  std::int64_t before = 0;
  std::int64_t steal = 0;
  line >> name;
  for (int field = 0; field < 7; ++field) line >> before;
  const long jiffies_per_second = ::sysconf(_SC_CLK_TCK);
  if (name != "cpu" || !(line >> steal) || steal < 0 || jiffies_per_second <= 0) return Nanos{0};
  const Nanos jiffy{1'000'000'000 / jiffies_per_second};
  return steal <= Nanos::max() / jiffy ? jiffy * steal : Nanos{0};
}

std::string wall_clock_utc() {
  const std::time_t seconds = std::time(nullptr);
  std::tm parts{};
  if (::gmtime_r(&seconds, &parts) == nullptr) return {};
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

}  // namespace

Reserve read_reserve(const LinuxRoots& roots) {
  // The first of equals is named.
  Reserve largest = fair_server(roots);
  for (Reserve other : {throttling(roots), cgroup_throttling(roots)}) {
    if (other.fraction > largest.fraction) largest = std::move(other);
  }
  if (largest.fraction <= 0.0) return {0.0, "nothing"};
  return largest;
}

HostFacts read_host_facts(const LinuxRoots& roots) {
  HostFacts facts;
  facts.utc = wall_clock_utc();
  utsname names{};
  if (::uname(&names) == 0) {
    facts.kernel = fmt::format("{} {} {} {}", names.sysname, names.release, names.version, names.machine);
  }
  facts.cpu_model = cpu_model(roots);
  facts.governor = governors(roots);
  facts.clock_source =
      read_line(roots.sysfs + "/devices/system/clocksource/clocksource0/current_clocksource").value_or("");
  const Result<Topology> topology = read_topology(roots);
  facts.cpu_count = topology.ok() ? static_cast<int>(topology->online().size()) : 0;
  facts.steal = steal_time(roots);
  return facts;
}

}  // namespace ctn::os
