// How much of the machine others used while a trial ran: ordinary scheduling shares with them, so its numbers mean
// little where that was much.
//
// It reads what the kernel counts in jiffies, for all CPUs together, and takes off what this process and the
// children that it waited for used. What a hypervisor took counts as used by others.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ctn::demo {

struct CpuTimes {
  std::int64_t busy = 0;   // all CPUs, all programs
  std::int64_t total = 0;  // busy and idle
  std::int64_t ours = 0;   // this process and its ended children
};

// Texts of /proc/stat and /proc/self/stat. Nothing where they are not as the kernel writes them.
std::optional<CpuTimes> parse_cpu_times(const std::string& stat, const std::string& self_stat);
std::optional<CpuTimes> read_cpu_times();

// Fraction of all CPU time between the two that others used; 0 where it cannot be told.
double others_share(const std::optional<CpuTimes>& before, const std::optional<CpuTimes>& after);

}  // namespace ctn::demo
