#include "os/linux/power.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>

namespace ctn::os {
namespace {

std::optional<bool> on_mains(const LinuxRoots& roots) {
  std::optional<bool> mains;
  std::optional<bool> battery;
  std::error_code error;
  const std::filesystem::directory_iterator supplies(roots.sysfs + "/class/power_supply", error);
  if (error) return std::nullopt;
  for (const std::filesystem::directory_entry& supply : supplies) {
    const std::string folder = supply.path().string();
    if (read_line(folder + "/scope") == "Device") continue;
    const std::optional<std::string> type = read_line(folder + "/type");
    if (type == "Mains") {
      const auto online = read_integer(folder + "/online");
      if (online) mains = mains.value_or(false) || *online != 0;
    } else if (type == "Battery") {
      const std::optional<std::string> status = read_line(folder + "/status");
      if (status && *status != "Unknown") battery = battery.value_or(true) && *status != "Discharging";
    }
  }
  return mains ? mains : battery;
}

std::optional<long> limit_khz(const std::string& folder) {
  const auto limit = read_integer(folder + "/scaling_max_freq");
  if (!limit || *limit <= 0 || *limit > std::numeric_limits<long>::max()) return std::nullopt;
  return static_cast<long>(*limit);
}

}  // namespace

PowerState read_power_state(const LinuxRoots& roots, const CpuSet& cpus) {
  PowerState state;
  state.on_mains = on_mains(roots);
  for (const int cpu : cpus.cpus()) {
    const std::string folder = fmt::format("{}/devices/system/cpu/cpu{}/cpufreq", roots.sysfs, cpu);
    state.cpus.push_back({cpu, limit_khz(folder), read_line(folder + "/scaling_governor").value_or("")});
  }
  return state;
}

std::map<int, Nanos> read_stolen_time(const LinuxRoots& roots) {
  std::map<int, Nanos> stolen;
  const long jiffies_per_second = ::sysconf(_SC_CLK_TCK);
  if (jiffies_per_second <= 0) return stolen;
  const Nanos jiffy{1'000'000'000 / jiffies_per_second};
  std::istringstream text(read_text(roots.procfs + "/stat").value_or(""));
  for (std::string line; std::getline(text, line) && line.starts_with("cpu");) {
    // "cpuN user nice system idle iowait irq softirq steal ..."; the line without a number is their sum.
    std::istringstream fields(line);
    std::string name;
    std::int64_t jiffies = -1;
    fields >> name;
    for (int field = 0; field < 8; ++field) fields >> jiffies;
    const auto cpu = parse_integer(std::string_view(name).substr(3));
    if (!fields || !cpu || *cpu < 0 || *cpu > std::numeric_limits<int>::max()) continue;
    if (jiffies >= 0 && jiffies <= Nanos::max() / jiffy) stolen[static_cast<int>(*cpu)] = jiffy * jiffies;
  }
  return stolen;
}

}  // namespace ctn::os
