#include "os/linux/privilege.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <string_view>

namespace ctn::os {
namespace {

constexpr int kCapSysNice = 23;  // its bit in the kernel's capability sets

bool names_cpu_controller(std::string_view controllers) {
  while (!controllers.empty()) {
    const std::size_t comma = controllers.find(',');
    if (controllers.substr(0, comma) == "cpu") return true;
    if (comma == std::string_view::npos) break;
    controllers.remove_prefix(comma + 1);
  }
  return false;
}

std::optional<RealTimeCgroup> read_cgroup(const std::string& folder) {
  const std::string file = folder + "/cpu.rt_runtime_us";
  const std::optional<std::int64_t> runtime = read_integer(file);
  if (!runtime) return std::nullopt;
  RealTimeCgroup cgroup{file, *runtime};
  const std::optional<std::int64_t> period = read_integer(folder + "/cpu.rt_period_us");
  if (period && *period > 0) cgroup.period_us = *period;
  return cgroup;
}

// Lines of /proc/self/cgroup: "number:controllers:path".
std::optional<RealTimeCgroup> cgroup_of_line(const LinuxRoots& roots, std::string_view line) {
  const std::size_t first = line.find(':');
  const std::size_t second = first == std::string_view::npos ? first : line.find(':', first + 1);
  if (second == std::string_view::npos) return std::nullopt;
  const std::string_view controllers = line.substr(first + 1, second - first - 1);
  if (!names_cpu_controller(controllers)) return std::nullopt;
  const std::string_view path = line.substr(second + 1);
  // In a container the path may be the host's, and the mount is the cgroup itself.
  for (const std::string_view mount : {controllers, std::string_view("cpu"), std::string_view("cpu,cpuacct")}) {
    const std::string top = fmt::format("{}/fs/cgroup/{}", roots.sysfs, mount);
    if (auto cgroup = read_cgroup(path == "/" ? top : fmt::format("{}{}", top, path))) return cgroup;
    if (auto cgroup = read_cgroup(top)) return cgroup;
  }
  return std::nullopt;
}

}  // namespace

bool has_cap_sys_nice(const LinuxRoots& roots) {
  const std::optional<std::string> status = read_text(roots.procfs + "/self/status");
  const std::optional<std::string> effective = status ? find_value(*status, "CapEff") : std::nullopt;
  if (!effective) return false;
  std::uint64_t bits = 0;
  std::from_chars(effective->data(), effective->data() + effective->size(), bits, 16);
  return (bits >> kCapSysNice & 1U) != 0;
}

std::string program_path(const LinuxRoots& roots) {
  std::array<char, 4096> path{};
  const ssize_t length = ::readlink((roots.procfs + "/self/exe").c_str(), path.data(), path.size());
  if (length <= 0) return "PROGRAM";
  return {path.data(), static_cast<std::size_t>(length)};
}

std::optional<RealTimeCgroup> real_time_cgroup(const LinuxRoots& roots) {
  const std::optional<std::string> cgroups = read_text(roots.procfs + "/self/cgroup");
  if (!cgroups) return std::nullopt;
  std::string_view rest = *cgroups;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    if (auto cgroup = cgroup_of_line(roots, rest.substr(0, end))) return cgroup;
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  return std::nullopt;
}

std::string how_to_permit(const LinuxRoots& roots) {
  const std::optional<RealTimeCgroup> cgroup = real_time_cgroup(roots);
  if (cgroup && cgroup->runtime_us == 0) {
    return fmt::format(
        "this process is in a control group without time for real-time threads: set some, as in "
        "`echo 950000 > {}` (each cgroup above needs at least as much), or start it in the top cgroup",
        cgroup->file);
  }
  if (has_cap_sys_nice(roots)) {
    return "this process has CAP_SYS_NICE, so something else forbids it: a control group (start it in the top cgroup, "
           "or boot with rt_group_sched=0), a container's system call filter, or a security module";
  }
  return fmt::format(
      "run as root; or grant it once to the program: `sudo setcap cap_sys_nice+ep {}`; or to the user: a line "
      "`USER - rtprio {}` in /etc/security/limits.conf and a new login; in a container: --cap-add=SYS_NICE",
      program_path(roots), kHighestPriority);
}

}  // namespace ctn::os
