#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "doctor/checks.h"

namespace ctn::doctor {
namespace {

constexpr double kSameSpeed = 0.05;  // CPUs that differ by less are of one kind: makers favour single cores a little
constexpr std::int64_t kSlowWakeUp = 100;  // us

std::string cpu_folder(const os::LinuxRoots& roots, int cpu) {
  return fmt::format("{}/devices/system/cpu/cpu{}", roots.sysfs, cpu);
}

const os::Cpu* find(const os::Topology& topology, int cpu) {
  for (const os::Cpu& known : topology.cpus) {
    if (known.number == cpu) return &known;
  }
  return nullptr;
}

os::CpuSet list_of(const std::string& path) {
  const Result<os::CpuSet> cpus = os::parse_cpu_list(os::read_line(path).value_or(""));
  return cpus.ok() ? *cpus : os::CpuSet{};  // "(null)" where there are none
}

// Capacity counts what a CPU does in a cycle, frequency does not.
std::optional<double> speed_of(const os::Topology& topology, int cpu, bool by_capacity) {
  const os::Cpu* const known = find(topology, cpu);
  if (!known) return std::nullopt;
  if (by_capacity) return known->capacity ? std::optional<double>(*known->capacity) : std::nullopt;
  return known->max_khz ? std::optional(static_cast<double>(*known->max_khz)) : std::nullopt;
}

struct Kind {
  std::vector<int> cpus;
  double speed = 0.0;
};

bool alike(double one, double other) { return std::abs(one - other) <= kSameSpeed * std::max(one, other); }

// In the order of the CPUs, since app files count them off in it. Empty where a CPU's speed is not known.
std::vector<Kind> kinds_of(const Observed& observed, bool by_capacity) {
  std::vector<Kind> kinds;
  for (const int cpu : observed.cpus.cpus()) {
    const auto speed = speed_of(observed.topology, cpu, by_capacity);
    if (!speed) return {};
    if (kinds.empty() || !alike(kinds.back().speed, *speed)) kinds.push_back({{}, *speed});
    kinds.back().cpus.push_back(cpu);
  }
  return kinds;
}

std::vector<std::string> cores_section(const std::vector<Kind>& kinds) {
  double fastest = 0.0;
  for (const Kind& kind : kinds) fastest = std::max(fastest, kind.speed);
  std::vector<std::string> lines{"cores:"};
  for (const Kind& kind : kinds) {
    const std::string name = kind.cpus.size() == 1 ? fmt::format("cpu{}", kind.cpus.front())
                                                   : fmt::format("cpu{}-{}", kind.cpus.front(), kind.cpus.back());
    lines.push_back(fmt::format("  {}: {{ count: {}, speed: {:.3g} }}", name, kind.cpus.size(), kind.speed / fastest));
  }
  return lines;
}

// The value of one file of each CPU -> the CPUs that have it.
std::map<std::string, os::CpuSet> by_value(const os::LinuxRoots& roots, const os::CpuSet& cpus,
                                           const std::string& file) {
  std::map<std::string, std::vector<int>> numbers;
  for (const int cpu : cpus.cpus()) {
    if (auto value = os::read_line(cpu_folder(roots, cpu) + file)) numbers[*value].push_back(cpu);
  }
  std::map<std::string, os::CpuSet> sets;
  for (auto& [value, with] : numbers) sets.emplace(value, os::CpuSet(std::move(with)));
  return sets;
}

std::string described(const std::map<std::string, os::CpuSet>& values) {
  std::vector<std::string> parts;
  for (const auto& [value, cpus] : values) parts.push_back(fmt::format("{} on CPUs {}", value, to_string(cpus)));
  return fmt::format("{}", fmt::join(parts, ", "));
}

// These drivers' "powersave" is a governor of its own that goes by an energy preference, not the lowest frequency.
bool hardware_governs(const os::LinuxRoots& roots, const os::CpuSet& cpus) {
  const auto drivers = by_value(roots, cpus, "/cpufreq/scaling_driver");
  return !drivers.empty() && std::all_of(drivers.begin(), drivers.end(), [](const auto& driver) {
    return driver.first == "intel_pstate" || driver.first == "amd-pstate-epp";
  });
}

struct IdleState {
  std::string name;
  std::int64_t latency = 0;  // us
};

IdleState deepest_idle(const os::LinuxRoots& roots, const os::CpuSet& cpus) {
  IdleState deepest;
  for (const int cpu : cpus.cpus()) {
    const std::string folder = cpu_folder(roots, cpu) + "/cpuidle";
    for (const int state : os::numbered_entries(folder, "state").value_or(std::vector<int>{})) {
      const std::string own = fmt::format("{}/state{}", folder, state);
      const std::int64_t latency = os::read_integer(own + "/latency").value_or(0);
      if (latency <= deepest.latency || os::read_integer(own + "/disable").value_or(0) != 0) continue;
      deepest = {os::read_line(own + "/name").value_or(fmt::format("state{}", state)), latency};
    }
  }
  return deepest;
}

std::vector<std::string> lines_for_cpus(const os::CpuSet& unusable, const os::CpuSet& online) {
  std::vector<std::string> lines;
  for (const int cpu : unusable.cpus()) {
    if (online.contains(cpu)) continue;
    lines.push_back(fmt::format("echo 1 | sudo tee /sys/devices/system/cpu/cpu{}/online", cpu));
  }
  if (lines.size() < unusable.size()) {
    lines.push_back(fmt::format("docker run --cpuset-cpus={} ...   # in a container", to_string(online)));
    lines.emplace_back("grep Cpus_allowed_list /proc/self/status   # what the cpuset leaves");
  }
  return lines;
}

std::optional<Finding> unusable_cpus(const Observed& observed, const os::CpuSet& online) {
  std::vector<int> numbers;
  std::string why;
  for (const WakeUps& one : observed.wake_ups) {
    if (!one.refused) continue;
    if (numbers.empty()) why = one.refused->problems().front().what;
    numbers.push_back(one.cpu);
  }
  if (numbers.empty()) return std::nullopt;
  const os::CpuSet cpus(std::move(numbers));
  return Finding{"cpus",
                 Verdict::kProblem,
                 fmt::format("CPUs {} cannot be used: {}", to_string(cpus), why),
                 "no thread can be pinned there, so a plan with these CPUs cannot be followed",
                 "name CPUs that are online and in this process's cpuset, or make them so",
                 lines_for_cpus(cpus, online)};
}

}  // namespace

Finding check_cpus(const Observed& observed) {
  const os::CpuSet online = observed.topology.online();
  if (auto unusable = unusable_cpus(observed, online)) return *unusable;
  const std::string found = fmt::format("CPUs {} of {} online", to_string(observed.cpus), to_string(online));
  if (common(online, observed.allowed) == online) return {"cpus", Verdict::kOk, found, {}, {}, {}};
  return {"cpus",
          Verdict::kNote,
          fmt::format("{}; this process may use {}", found, to_string(observed.allowed)),
          "a cpuset, taskset or isolcpus keeps this process from the others, and plans with it",
          "if the app should have more, start it with more",
          {fmt::format("taskset -c {} COMMAND", to_string(online)),
           fmt::format("docker run --cpuset-cpus={} ...   # in a container", to_string(online))}};
}

Finding check_capacity(const Observed& observed) {
  std::vector<Kind> kinds = kinds_of(observed, true);
  if (kinds.size() < 2) {
    // Equal capacities may just mean that the kernel was not told.
    if (auto others = kinds_of(observed, false); others.size() > 1) kinds = std::move(others);
  }
  if (kinds.size() < 2) {
    return {"capacity", Verdict::kOk, kinds.empty() ? "all CPUs alike, as far as can be told" : "all CPUs alike",
            {},         {},           {}};
  }
  return {"capacity",
          Verdict::kNote,
          fmt::format("CPUs of different speed, in {} rows", kinds.size()),
          "unless it is told, Catan takes all cores for alike and plans the slow ones too fast",
          "put this into the app file (speeds from cpu_capacity, or else from the highest frequency)",
          cores_section(kinds)};
}

Finding check_smt(const os::LinuxRoots& roots, const Observed& observed) {
  std::map<std::pair<int, int>, std::vector<int>> cores;
  for (const int cpu : observed.cpus.cpus()) {
    const os::Cpu* const known = find(observed.topology, cpu);
    if (known && known->online) cores[{known->package, known->core}].push_back(cpu);
  }
  std::vector<std::string> shared;
  std::vector<int> firsts;
  for (const auto& [core, cpus] : cores) {
    firsts.push_back(cpus.front());
    if (cpus.size() > 1) shared.push_back(to_string(os::CpuSet(cpus)));
  }
  if (shared.empty()) return {"smt", Verdict::kOk, "each CPU is a core of its own", {}, {}, {}};
  return {"smt",
          Verdict::kNote,
          fmt::format("hardware threads share cores: {}", fmt::join(shared, " and ")),
          "two CPUs of one core slow each other down, so compute times depend on what runs beside",
          "give Catan one CPU of each core, or turn the others off",
          {fmt::format("catan run APP --cpus {}", to_string(os::CpuSet(firsts))),
           fmt::format("echo off | sudo tee {}/devices/system/cpu/smt/control", roots.sysfs)}};
}

Finding check_isolated(const os::LinuxRoots& roots, const Observed& observed) {
  const std::string folder = roots.sysfs + "/devices/system/cpu";
  const os::CpuSet isolated = list_of(folder + "/isolated");
  const os::CpuSet tickless = list_of(folder + "/nohz_full");
  std::vector<std::string> parts;
  if (!isolated.empty()) parts.push_back(fmt::format("isolated: {}", to_string(isolated)));
  if (!tickless.empty()) parts.push_back(fmt::format("nohz_full: {}", to_string(tickless)));
  if (parts.empty()) return {"isolated", Verdict::kOk, "no CPU is isolated", {}, {}, {}};
  const std::string found = fmt::format("{}", fmt::join(parts, "; "));
  if (isolated.empty()) return {"isolated", Verdict::kOk, found, {}, {}, {}};
  const bool mixed = !common(observed.cpus, isolated).empty() && common(observed.cpus, isolated) != observed.cpus;
  return {"isolated",
          Verdict::kNote,
          found,
          mixed
              ? "on isolated CPUs there is less noise, but the kernel moves no ordinary thread there or away: the pool "
                "of a library stays on the CPU where it began. These CPUs are of both sorts"
              : "on isolated CPUs there is less noise, but the kernel moves no ordinary thread there or away: the pool "
                "of a library stays on the CPU where it began",
          "give the app the isolated CPUs and leave the others to everything else",
          {fmt::format("catan run APP --cpus {}", to_string(isolated))}};
}

Finding check_governor(const os::LinuxRoots& roots, const Observed& observed) {
  const auto governors = by_value(roots, observed.cpus, "/cpufreq/scaling_governor");
  if (governors.empty()) {
    return {"governor", Verdict::kOk, "no frequency scaling to be seen (cpufreq)", {}, {}, {}};
  }
  std::string found = described(governors);
  if (governors.size() == 1 && governors.begin()->first == "performance") {
    return {"governor", Verdict::kOk, found, {}, {}, {}};
  }
  const bool hardware = hardware_governs(roots, observed.cpus);
  const auto preferences = by_value(roots, observed.cpus, "/cpufreq/energy_performance_preference");
  if (hardware && !preferences.empty()) found += "; energy preference " + described(preferences);
  const bool eager = hardware && preferences.size() == 1 && preferences.begin()->first == "performance";
  return {"governor",
          eager      ? Verdict::kOk
          : hardware ? Verdict::kNote
                     : Verdict::kWarning,
          found,
          eager ? ""
                : "the clock rises only after load, so a run after a pause takes longer than one in a row, and "
                  "measured compute times "
                  "are those of a slower machine",
          eager ? "" : "keep the clock up",
          eager
              ? std::vector<std::string>{}
              : std::vector<std::string>{fmt::format(
                    "for c in {}; do echo performance | sudo tee {}/devices/system/cpu/cpu$c/cpufreq/scaling_governor; "
                    "done",
                    fmt::join(observed.cpus.cpus(), " "), roots.sysfs)}};
}

Finding check_frequency_limit(const os::LinuxRoots& roots, const Observed& observed) {
  std::vector<int> limited;
  double min = 1.0;
  for (const int cpu : observed.cpus.cpus()) {
    const auto allowed = os::read_integer(cpu_folder(roots, cpu) + "/cpufreq/scaling_max_freq");
    const auto possible = os::read_integer(cpu_folder(roots, cpu) + "/cpufreq/cpuinfo_max_freq");
    if (!allowed || !possible || *possible <= 0 || *allowed >= *possible) continue;
    limited.push_back(cpu);
    min = std::min(min, static_cast<double>(*allowed) / static_cast<double>(*possible));
  }
  if (limited.empty()) return {"frequency_limit", Verdict::kOk, "no limit below the CPU's own", {}, {}, {}};
  return {"frequency_limit",
          Verdict::kWarning,
          fmt::format("CPUs {} are held to {:.0f} % of their highest frequency", to_string(os::CpuSet(limited)),
                      100.0 * min),
          "all compute times are longer by as much",
          "lift the limit (power settings or a thermal daemon may set it again)",
          {fmt::format("for c in {}; do cd {}/devices/system/cpu/cpu$c/cpufreq && cat cpuinfo_max_freq | sudo tee "
                       "scaling_max_freq; done",
                       fmt::join(limited, " "), roots.sysfs)}};
}

Finding check_boost(const os::LinuxRoots& roots) {
  const std::string folder = roots.sysfs + "/devices/system/cpu";
  const auto boost = os::read_integer(folder + "/cpufreq/boost");
  const auto no_turbo = os::read_integer(folder + "/intel_pstate/no_turbo");
  if (!boost && !no_turbo) return {"boost", Verdict::kOk, "no boost to be seen", {}, {}, {}};
  const bool on = boost ? *boost != 0 : *no_turbo == 0;
  if (!on) return {"boost", Verdict::kOk, "off", {}, {}, {}};
  return {"boost",
          Verdict::kNote,
          "on",
          "how fast a core is depends on how many are busy and how hot they are: faster on average, less even",
          "leave it on for speed; for compute times that repeat (benchmarks), turn it off",
          {boost ? fmt::format("echo 0 | sudo tee {}/cpufreq/boost", folder)
                 : fmt::format("echo 1 | sudo tee {}/intel_pstate/no_turbo", folder)}};
}

Finding check_idle(const os::LinuxRoots& roots, const Observed& observed) {
  if (observed.not_ready) {
    const Problem& why = observed.not_ready->problems().front();
    return {"idle",   Verdict::kWarning,
            why.what, "an idle virtual CPU is given to others on the host, and comes back late and with cold caches",
            why.hint, {fmt::format("sudo chmod o+rw {}/cpu_dma_latency", roots.devices)}};
  }
  if (observed.keeps_ready) return {"idle", Verdict::kOk, "idle virtual CPUs can be kept ready", {}, {}, {}};
  const IdleState deepest = deepest_idle(roots, observed.cpus);
  if (deepest.latency == 0) return {"idle", Verdict::kOk, "no idle states to be seen", {}, {}, {}};
  const std::string found = fmt::format("idle CPUs take up to {} us to wake up ({})", deepest.latency, deepest.name);
  if (deepest.latency < kSlowWakeUp) return {"idle", Verdict::kOk, found, {}, {}, {}};
  return {"idle",
          Verdict::kNote,
          found,
          "a trigger to an idle core can be that late; on a busy one it makes no difference",
          "if that matters more than energy, turn the deep states off (until the next boot)",
          {fmt::format("sudo cpupower idle-set -D {}", kSlowWakeUp - 1)}};
}

}  // namespace ctn::doctor
