#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "doctor/checks.h"
#include "os/linux/control_groups.h"
#include "os/linux/privilege.h"

namespace ctn::doctor {
namespace {

constexpr std::int64_t kUsualRuntime = 950'000;
constexpr std::int64_t kSecond = 1'000'000;  // in microseconds
constexpr double kLargeReserve = 0.1;

// The soft limit of a line of /proc/self/limits; nothing where it is unlimited or not there.
std::optional<std::int64_t> limit(const os::LinuxRoots& roots, std::string_view name) {
  std::istringstream lines(os::read_text(roots.procfs + "/self/limits").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name)) continue;
    std::istringstream rest(line.substr(name.size()));
    std::string soft;
    rest >> soft;
    return os::parse_integer(soft);
  }
  return std::nullopt;
}

std::vector<std::string> lines_for_permission(const os::LinuxRoots& roots) {
  return {
      fmt::format("sudo setcap cap_sys_nice+ep {}   # and the same for the app's program; or", program_path(roots)),
      fmt::format("echo \"$USER - rtprio {}\" | sudo tee /etc/security/limits.d/catan.conf   # then log in again; or",
                  os::kHighestPriority),
      "docker run --cap-add=SYS_NICE ...   # in a container"};
}

std::string top_folder(const os::LinuxRoots& roots, const std::string& own_file) {
  const std::vector<std::string> folders = cgroup_folders(roots, "cpu");
  return folders.empty() ? own_file.substr(0, own_file.rfind('/')) : folders.front();
}

// Each cgroup from the top down needs time before the next may have some.
std::vector<std::string> lines_for_cgroup(const os::LinuxRoots& roots, const std::string& own_file) {
  std::vector<std::string> lines;
  std::int64_t above = kUsualRuntime;
  for (const std::string& folder : cgroup_folders(roots, "cpu")) {
    const std::string file = folder + "/cpu.rt_runtime_us";
    const auto runtime = os::read_integer(file);
    if (runtime && *runtime > 0) above = std::min(above, *runtime);
    if (runtime && *runtime == 0) lines.push_back(fmt::format("echo {} | sudo tee {}", above, file));
  }
  if (lines.empty()) lines.push_back(fmt::format("echo {} | sudo tee {}", above, own_file));
  lines.push_back(
      fmt::format("echo $$ | sudo tee {}/tasks   # or: this shell to the top cgroup", top_folder(roots, own_file)));
  return lines;
}

Finding cgroup_without_time(const os::LinuxRoots& roots, const std::string& file) {
  return {"group",
          Verdict::kProblem,
          fmt::format("{} is 0", file),
          "this process is in a control group that has no time for real-time threads: even root is refused (EPERM), "
          "and Catan can only set rates",
          "give time to the cgroup and those above it, as root (less where cgroups beside it have some already), or "
          "start the app from a shell that is in the top cgroup",
          lines_for_cgroup(roots, file)};
}

// Nothing can be read there, but only this is known to refuse root.
Finding privileged_but_refused(const std::string& own_cgroup) {
  Finding finding{"group",
                  Verdict::kProblem,
                  "real-time levels are refused although this process has CAP_SYS_NICE",
                  "a kernel with real-time group scheduling (CONFIG_RT_GROUP_SCHED) refuses them to all but the top "
                  "control group; a container's system call filter and a security module can do the same",
                  "start from the top cgroup, or boot the kernel with rt_group_sched=0; in a container, allow "
                  "sched_setscheduler",
                  {}};
  if (!own_cgroup.empty()) finding.lines.push_back(fmt::format("echo $$ | sudo tee {}/cgroup.procs", own_cgroup));
  finding.lines.emplace_back("docker run --security-opt seccomp=unconfined --cap-add=SYS_NICE ...   # in a container");
  return finding;
}

std::string fair_server_folder(const os::LinuxRoots& roots) { return roots.sysfs + "/kernel/debug/sched/fair_server"; }

bool fair_server_files(const os::LinuxRoots& roots) {
  return os::numbered_entries(fair_server_folder(roots), "cpu").has_value();
}

std::vector<std::string> lines_for_usual_reserve(const os::LinuxRoots& roots, const std::string& reserved_by) {
  if (reserved_by.starts_with("fair server")) {
    return {fmt::format("for f in {}/cpu*/runtime; do echo 50000000 | sudo tee $f; done", fair_server_folder(roots))};
  }
  std::vector<std::string> lines{fmt::format("sudo sysctl -w kernel.sched_rt_runtime_us={}", kUsualRuntime)};
  const auto cgroup = real_time_cgroup(roots);
  if (cgroup && cgroup->runtime_us > 0) {
    const std::int64_t usual = cgroup->period_us * kUsualRuntime / kSecond;
    if (cgroup->runtime_us < usual) lines.push_back(fmt::format("echo {} | sudo tee {}", usual, cgroup->file));
  }
  return lines;
}

struct Quota {
  std::string file;
  double cpus = 0.0;
};

// "max 100000" or "50000 100000".
std::optional<Quota> read_quota_2(const std::string& folder) {
  const std::string file = folder + "/cpu.max";
  std::istringstream words(os::read_line(file).value_or(""));
  double runtime = 0.0;
  double period = 0.0;
  if (!(words >> runtime >> period) || period <= 0.0) return std::nullopt;
  return Quota{file, runtime / period};
}

std::optional<Quota> read_quota_1(const std::string& folder) {
  const std::string file = folder + "/cpu.cfs_quota_us";
  const auto runtime = os::read_integer(file);
  const auto period = os::read_integer(folder + "/cpu.cfs_period_us");
  if (!runtime || !period || *runtime <= 0 || *period <= 0) return std::nullopt;
  return Quota{file, static_cast<double>(*runtime) / static_cast<double>(*period)};
}

std::optional<Quota> tightest_quota(const os::LinuxRoots& roots) {
  std::optional<Quota> tightest;
  const auto consider = [&](std::optional<Quota> quota) {
    if (quota && (!tightest || quota->cpus < tightest->cpus)) tightest = std::move(quota);
  };
  for (const std::string& folder : cgroup_folders(roots, "")) consider(read_quota_2(folder));
  for (const std::string& folder : cgroup_folders(roots, "cpu")) consider(read_quota_1(folder));
  return tightest;
}

}  // namespace

Finding check_permission(const os::LinuxRoots& roots, const Observed& observed) {
  if (observed.real_time.permitted) {
    return {
        "permission", Verdict::kOk, fmt::format("real-time levels 1 to {} can be had (tried)", os::kHighestPriority),
        {},           {},           {}};
  }
  const bool capable = has_cap_sys_nice(roots);
  const auto rtprio = limit(roots, "Max realtime priority");
  Finding finding{"permission",
                  Verdict::kProblem,
                  fmt::format("real-time levels are refused (tried); {} CAP_SYS_NICE, RLIMIT_RTPRIO {}",
                              capable ? "has" : "no", rtprio ? fmt::format("{}", *rtprio) : "unknown"),
                  "rates only: Catan still plans and triggers, but nothing is kept from anything else's CPU",
                  "get the permission, one of these ways",
                  lines_for_permission(roots)};
  if (capable || (rtprio && *rtprio >= os::kHighestPriority)) {
    finding.hint = "the permission is there; fix what else refuses it: see `group`";
    finding.lines.clear();
  }
  return finding;
}

Finding check_cgroup(const os::LinuxRoots& roots, const Observed& observed) {
  const auto cgroup = real_time_cgroup(roots);
  if (cgroup && cgroup->runtime_us == 0) return cgroup_without_time(roots, cgroup->file);
  const auto rtprio = limit(roots, "Max realtime priority");
  const bool allowed = has_cap_sys_nice(roots) || (rtprio && *rtprio >= os::kHighestPriority);
  if (!observed.real_time.permitted && allowed) {
    const std::vector<std::string> folders = cgroup_folders(roots, cgroup ? "cpu" : "");
    Finding finding = privileged_but_refused(folders.empty() ? "" : folders.front());
    if (!has_cap_sys_nice(roots)) {
      finding.found = fmt::format("real-time levels are refused although RLIMIT_RTPRIO is {}", *rtprio);
    }
    return finding;
  }
  const std::string found = !cgroup ? "no real-time budget by control group"
                            : cgroup->runtime_us < 0
                                ? fmt::format("{} sets no limit", cgroup->file)
                                : fmt::format("{} of {} us in {}", cgroup->runtime_us, cgroup->period_us, cgroup->file);
  return {"group", Verdict::kOk, found, {}, {}, {}};
}

Finding check_time_limit(const os::LinuxRoots& roots) {
  const auto longest = limit(roots, "Max realtime timeout");
  if (!longest) return {"time_limit", Verdict::kOk, "no RLIMIT_RTTIME", {}, {}, {}};
  return {"time_limit",
          *longest < kSecond ? Verdict::kProblem : Verdict::kWarning,
          fmt::format("RLIMIT_RTTIME is {} us", *longest),
          "the kernel kills a program whose real-time thread computes this long without sleeping: one long run of a "
          "node is enough",
          "lift the limit in the shell that starts the app (or `LimitRTTIME=infinity` in its systemd unit)",
          {"ulimit -R unlimited"}};
}

Finding check_slack(const os::LinuxRoots& roots, const Observed& observed) {
  const os::RealTimeFacts& facts = observed.real_time;
  Finding finding{
      "slack",
      Verdict::kOk,
      fmt::format("{:.3g} % of each CPU is kept for ordinary threads by {}", 100.0 * facts.reserved, facts.reserved_by),
      {},
      {},
      {}};
  if (facts.reserved > kLargeReserve) {
    finding.verdict = facts.reserved >= 1.0 ? Verdict::kProblem : Verdict::kWarning;
    finding.meaning = facts.reserved >= 1.0 ? "real-time threads get no CPU time at all"
                                            : "plans leave that much of each CPU unused, and a percentage point more";
    finding.hint = "let them have the usual 95 %";
    finding.lines = lines_for_usual_reserve(roots, facts.reserved_by);
  } else if (facts.reserved_by.find("assumed") != std::string::npos) {
    finding.verdict = Verdict::kNote;
    finding.meaning = "what this kernel keeps cannot be read, so plans have the slack for its default: 6 %";
    finding.hint = "if debugfs is there but not mounted, mount it; else leave it so";
    finding.lines = {"sudo mount -t debugfs none /sys/kernel/debug; sudo ls /sys/kernel/debug/sched/fair_server"};
  } else if (facts.reserved <= 0.0) {
    finding.verdict = Verdict::kNote;
    finding.found = "nothing is kept for ordinary threads";
    finding.meaning = "plans still leave them 6 %, but any real-time thread that hangs freezes the machine";
    finding.hint = "keep the usual 5 % for them, unless it was taken away on purpose";
    finding.lines = lines_for_usual_reserve(roots, fair_server_files(roots) ? "fair server" : "throttling");
  }
  return finding;
}

Finding check_quota(const os::LinuxRoots& roots) {
  const auto quota = tightest_quota(roots);
  if (!quota) return {"quota", Verdict::kOk, "no CPU quota by control group", {}, {}, {}};
  const bool version_2 = quota->file.ends_with("cpu.max");
  return {"quota",
          Verdict::kWarning,
          fmt::format("{:.3g} CPUs' time by {}", quota->cpus, quota->file),
          "once the cgroup has used that up, its ordinary threads stop until the next period (0.1 s): libraries' "
          "pools, the recorder, re-planning, and without real-time permission the nodes too. Real-time threads are not "
          "counted",
          "take the quota away (docker run without --cpus; systemd: CPUQuota=)",
          {fmt::format("echo {} | sudo tee {}", version_2 ? "max" : "-1", quota->file)}};
}

}  // namespace ctn::doctor
