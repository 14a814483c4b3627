#include "os/linux/topology.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace ctn::os {
namespace {

template <class T>
std::optional<T> read_positive(const std::string& path) {
  const std::optional<std::int64_t> number = read_integer(path);
  if (!number || *number <= 0 || *number > std::numeric_limits<T>::max()) return std::nullopt;
  return static_cast<T>(*number);
}

std::optional<CpuSet> read_cpu_list(const std::string& path) {
  const std::optional<std::string> line = read_line(path);
  if (!line) return std::nullopt;
  Result<CpuSet> cpus = parse_cpu_list(*line);
  if (!cpus.ok()) return std::nullopt;
  return std::move(*cpus);
}

// The lowest hardware thread of the core names it, where the kernel lists them: `core_id` alone repeats from cluster to
// cluster on ARM.
int read_core(const std::string& folder, int cpu) {
  for (const char* name : {"core_cpus_list", "thread_siblings_list"}) {
    const std::optional<CpuSet> siblings = read_cpu_list(fmt::format("{}/topology/{}", folder, name));
    if (siblings && siblings->contains(cpu)) return siblings->cpus().front();
  }
  const std::optional<std::int64_t> id = read_integer(folder + "/topology/core_id");
  const bool usable = id && *id >= 0 && *id <= std::numeric_limits<int>::max();
  return usable ? static_cast<int>(*id) : -1 - cpu;
}

int read_package(const std::string& folder) {
  const std::optional<std::int64_t> id = read_integer(folder + "/topology/physical_package_id");
  const bool usable = id && *id >= 0 && *id <= std::numeric_limits<int>::max();
  return usable ? static_cast<int>(*id) : 0;
}

}  // namespace

Result<Topology> read_topology(const LinuxRoots& roots) {
  const std::string cpus_folder = roots.sysfs + "/devices/system/cpu";
  const std::optional<CpuSet> online = read_cpu_list(cpus_folder + "/online");
  std::vector<int> numbers = numbered_entries(cpus_folder, "cpu").value_or(std::vector<int>{});
  if (online) numbers.insert(numbers.end(), online->cpus().begin(), online->cpus().end());
  const CpuSet all(std::move(numbers));
  if (all.empty()) {
    return Error::environment(fmt::format("{} shows no CPU", cpus_folder), "mount sysfs on /sys");
  }
  Topology topology;
  for (const int number : all.cpus()) {
    const std::string folder = fmt::format("{}/cpu{}", cpus_folder, number);
    Cpu cpu;
    cpu.number = number;
    cpu.online = online ? online->contains(number) : read_integer(folder + "/online").value_or(1) != 0;
    cpu.core = read_core(folder, number);
    cpu.package = read_package(folder);
    cpu.max_khz = read_positive<long>(folder + "/cpufreq/cpuinfo_max_freq");
    cpu.capacity = read_positive<int>(folder + "/cpu_capacity");
    topology.cpus.push_back(cpu);
  }
  return topology;
}

Result<CpuSet> read_online_cpus(const LinuxRoots& roots) {
  if (const auto online = read_cpu_list(roots.sysfs + "/devices/system/cpu/online")) return *online;
  const Result<Topology> topology = read_topology(roots);
  if (!topology.ok()) return topology.error();
  return topology->online();
}

}  // namespace ctn::os
