// Each check's verdicts on made-up machines, and a check-up of the real one.
#include "doctor/checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "os/linux/control_groups.h"
#include "os/linux/linux_os.h"
#include "os/linux/testing/fabricated_tree.h"

namespace ctn::doctor {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Four CPUs, all that is fine.
Observed fine_machine() {
  Observed observed;
  observed.cpus = os::CpuSet{0, 1, 2, 3};
  observed.allowed = observed.cpus;
  for (const int number : observed.cpus.cpus()) {
    os::Cpu cpu;
    cpu.number = number;
    cpu.core = number;
    observed.topology.cpus.push_back(cpu);
    observed.wake_ups.push_back({number, {10us, 20us, 30us}, std::nullopt});
    observed.ordinary.push_back({number, {60us, 70us, 80us}, std::nullopt});
  }
  observed.real_time = {true, "", 0.05, "throttling"};
  observed.level = os::Level::kDispatcher;
  observed.measured = 300ms;
  return observed;
}

class LinuxCheckup : public testing::Test {
 protected:
  void write_cpus(const std::string& file, const std::string& content) {
    for (const int cpu : machine_.cpus.cpus()) tree_.write_cpu(cpu, file, content);
  }
  void refuse(const std::string& capabilities, const std::string& rtprio) {
    machine_.real_time.permitted = false;
    tree_.write("proc/self/status", "CapEff:\t" + capabilities + "\n");
    tree_.write("proc/self/limits", "Max realtime priority     " + rtprio + "                    " + rtprio + "\n");
  }
  os::LinuxRoots roots() const { return tree_.roots(); }

  os::FabricatedTree tree_;
  Observed machine_ = fine_machine();
};

void expect(const Finding& finding, Verdict verdict, const std::string& found) {
  EXPECT_EQ(finding.verdict, verdict) << finding.check << ": " << finding.found;
  EXPECT_THAT(finding.found, HasSubstr(found)) << finding.check;
  EXPECT_EQ(finding.meaning.empty(), verdict == Verdict::kOk) << finding.check;
  EXPECT_EQ(finding.hint.empty(), verdict == Verdict::kOk) << finding.check;
}

TEST_F(LinuxCheckup, MachineThatShowsNothingIsFine) {
  for (const Finding& finding : judge(roots(), machine_)) expect(finding, Verdict::kOk, "");
  EXPECT_EQ(judge({"/nowhere", "/nowhere", "/nowhere"}, Observed{}).size(), judge(roots(), machine_).size());
}

TEST_F(LinuxCheckup, WithoutPermissionTheWaysToGetItAreNamed) {
  refuse("0000000000000000", "0");
  const Finding finding = check_permission(roots(), machine_);
  expect(finding, Verdict::kProblem, "no CAP_SYS_NICE, RLIMIT_RTPRIO 0");
  EXPECT_THAT(finding.lines, Contains(HasSubstr("setcap cap_sys_nice+ep")));
  EXPECT_THAT(finding.lines, Contains(HasSubstr("rtprio 70")));
  EXPECT_THAT(finding.meaning, HasSubstr("rates only"));
  expect(check_cgroup(roots(), machine_), Verdict::kOk, "");
}

TEST_F(LinuxCheckup, PrivilegedButRefusedPointsToGroupScheduling) {
  refuse("0000000000800000", "0");
  tree_.write("proc/self/cgroup", "0::/app\n").write("sys/fs/cgroup/app/cpu.max", "max 100000\n");
  expect(check_permission(roots(), machine_), Verdict::kProblem, "has CAP_SYS_NICE");
  const Finding finding = check_cgroup(roots(), machine_);
  expect(finding, Verdict::kProblem, "although this process has CAP_SYS_NICE");
  EXPECT_THAT(finding.hint, HasSubstr("rt_group_sched=0"));
  EXPECT_THAT(finding.lines.front(), HasSubstr("/sys/fs/cgroup/cgroup.procs"));
  refuse("0000000000000000", "70");
  expect(check_cgroup(roots(), machine_), Verdict::kProblem, "although RLIMIT_RTPRIO is 70");
  refuse("0000000000000000", "69");
  expect(check_cgroup(roots(), machine_), Verdict::kOk, "");
}

TEST_F(LinuxCheckup, CgroupWithoutTimeIsGivenSomeFromTheTopDown) {
  refuse("0000000000800000", "0");
  tree_.write("proc/self/cgroup", "3:cpu,cpuacct:/a/b\n");
  tree_.write("sys/fs/cgroup/cpu,cpuacct/cpu.rt_runtime_us", "900000\n");
  tree_.write("sys/fs/cgroup/cpu,cpuacct/a/cpu.rt_runtime_us", "0\n");
  tree_.write("sys/fs/cgroup/cpu,cpuacct/a/b/cpu.rt_runtime_us", "0\n");
  const Finding finding = check_cgroup(roots(), machine_);
  expect(finding, Verdict::kProblem, "a/b/cpu.rt_runtime_us is 0");
  const std::string top = roots().sysfs + "/fs/cgroup/cpu,cpuacct";
  EXPECT_THAT(finding.lines, ElementsAre("echo 900000 | sudo tee " + top + "/a/cpu.rt_runtime_us",
                                         "echo 900000 | sudo tee " + top + "/a/b/cpu.rt_runtime_us",
                                         "echo $$ | sudo tee " + top + "/tasks   # or: this shell to the top cgroup"));
  EXPECT_THAT(cgroup_folders(roots(), "cpuacct"), ElementsAre(top, top + "/a", top + "/a/b"));
  EXPECT_THAT(cgroup_folders(roots(), "memory"), IsEmpty());
}

TEST_F(LinuxCheckup, TimeLimitKills) {
  tree_.write("proc/self/limits", "Max realtime timeout      200000               unlimited            us\n");
  expect(check_time_limit(roots()), Verdict::kProblem, "200000 us");
  tree_.write("proc/self/limits", "Max realtime timeout      5000000              unlimited            us\n");
  expect(check_time_limit(roots()), Verdict::kWarning, "5000000 us");
  tree_.write("proc/self/limits", "Max realtime timeout      unlimited            unlimited            us\n");
  expect(check_time_limit(roots()), Verdict::kOk, "no RLIMIT_RTTIME");
}

TEST_F(LinuxCheckup, SlackFollowsWhatTheKernelKeeps) {
  expect(check_slack(roots(), machine_), Verdict::kOk, "5 % of each CPU is kept for ordinary threads by throttling");
  machine_.real_time.reserved_by = "fair server (assumed default)";
  expect(check_slack(roots(), machine_), Verdict::kNote, "assumed");
  machine_.real_time = {true, "", 0.0, "nothing"};
  expect(check_slack(roots(), machine_), Verdict::kNote, "nothing is kept");
  machine_.real_time = {true, "", 0.3, "throttling"};
  expect(check_slack(roots(), machine_), Verdict::kWarning, "30 %");
  EXPECT_THAT(check_slack(roots(), machine_).lines, ElementsAre("sudo sysctl -w kernel.sched_rt_runtime_us=950000"));
  machine_.real_time.reserved_by = "fair server";
  EXPECT_THAT(check_slack(roots(), machine_).lines, ElementsAre(HasSubstr("fair_server/cpu*/runtime")));
  machine_.real_time = {true, "", 1.0, "throttling"};
  expect(check_slack(roots(), machine_), Verdict::kProblem, "100 %");
}

TEST_F(LinuxCheckup, ThrottlingCgroupIsNamedToo) {
  machine_.real_time = {true, "", 0.4, "throttling"};
  tree_.write("proc/self/cgroup", "1:cpu:/a\n").write("sys/fs/cgroup/cpu/a/cpu.rt_runtime_us", "300000\n");
  tree_.write("sys/fs/cgroup/cpu/a/cpu.rt_period_us", "500000\n");
  EXPECT_THAT(check_slack(roots(), machine_).lines, Contains(HasSubstr("echo 475000 | sudo tee")));
}

TEST_F(LinuxCheckup, TightestQuotaOfAllCgroupsAbove) {
  tree_.write("proc/self/cgroup", "0::/a/b\n").write("sys/fs/cgroup/a/cpu.max", "50000 100000\n");
  tree_.write("sys/fs/cgroup/a/b/cpu.max", "200000 100000\n");
  expect(check_quota(roots()), Verdict::kWarning, "0.5 CPUs' time by " + roots().sysfs + "/fs/cgroup/a/cpu.max");
  tree_.write("sys/fs/cgroup/a/cpu.max", "max 100000\n").write("sys/fs/cgroup/a/b/cpu.max", "max 100000\n");
  expect(check_quota(roots()), Verdict::kOk, "no CPU quota");
}

TEST_F(LinuxCheckup, QuotaOfVersionOneAndOfAContainer) {
  tree_.write("proc/self/cgroup", "2:cpu:/on/the/host\n").write("sys/fs/cgroup/cpu/cpu.cfs_quota_us", "150000\n");
  tree_.write("sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n");
  expect(check_quota(roots()), Verdict::kWarning, "1.5 CPUs");
  EXPECT_THAT(check_quota(roots()).lines.front(), HasSubstr("echo -1"));
  tree_.write("sys/fs/cgroup/cpu/cpu.cfs_quota_us", "-1\n");
  expect(check_quota(roots()), Verdict::kOk, "");
}

TEST_F(LinuxCheckup, CpusThatCannotBeUsed) {
  machine_.topology.cpus[3].online = false;
  machine_.wake_ups[3].refused = Error::environment("cannot bind", "name others");
  const Finding finding = check_cpus(machine_);
  expect(finding, Verdict::kProblem, "CPUs 3 cannot be used: cannot bind");
  EXPECT_THAT(finding.lines, ElementsAre("echo 1 | sudo tee /sys/devices/system/cpu/cpu3/online"));
  machine_.topology.cpus[3].online = true;
  EXPECT_THAT(check_cpus(machine_).lines, Contains(HasSubstr("--cpuset-cpus=0-3")));
}

TEST_F(LinuxCheckup, CpusThatAreKeptFromUs) {
  machine_.allowed = os::CpuSet{0, 1};
  machine_.cpus = machine_.allowed;
  expect(check_cpus(machine_), Verdict::kNote, "CPUs 0-1 of 0-3 online; this process may use 0-1");
}

TEST_F(LinuxCheckup, DifferentCpusGetASectionForTheAppFile) {
  for (os::Cpu& cpu : machine_.topology.cpus) cpu.capacity = cpu.number < 3 ? 446 : 1024;
  const Finding finding = check_capacity(machine_);
  expect(finding, Verdict::kNote, "different speed");
  EXPECT_THAT(finding.lines,
              ElementsAre("cores:", "  cpu0-2: { count: 3, speed: 0.436 }", "  cpu3: { count: 1, speed: 1 }"));
}

TEST_F(LinuxCheckup, FrequencyTellsSpeedWhereCapacityDoesNot) {
  for (os::Cpu& cpu : machine_.topology.cpus) {
    cpu.capacity = 1024;
    cpu.max_khz = cpu.number < 2 ? 5'000'000 : 2'500'000;
  }
  EXPECT_THAT(check_capacity(machine_).lines, Contains("  cpu2-3: { count: 2, speed: 0.5 }"));
  for (os::Cpu& cpu : machine_.topology.cpus) cpu.max_khz = cpu.number == 0 ? 5'100'000 : 5'000'000;
  expect(check_capacity(machine_), Verdict::kOk, "alike");
}

TEST_F(LinuxCheckup, HardwareThreadsOfOneCore) {
  for (os::Cpu& cpu : machine_.topology.cpus) cpu.core = cpu.number % 2;
  const Finding finding = check_smt(roots(), machine_);
  expect(finding, Verdict::kNote, "0,2 and 1,3");
  EXPECT_THAT(finding.lines.front(), HasSubstr("--cpus 0-1"));
  machine_.cpus = os::CpuSet{0, 1};
  expect(check_smt(roots(), machine_), Verdict::kOk, "core of its own");
}

TEST_F(LinuxCheckup, IsolatedCpus) {
  tree_.write("sys/devices/system/cpu/isolated", "\n").write("sys/devices/system/cpu/nohz_full", "(null)\n");
  expect(check_isolated(roots(), machine_), Verdict::kOk, "no CPU is isolated");
  tree_.write("sys/devices/system/cpu/isolated", "2-3\n").write("sys/devices/system/cpu/nohz_full", "2-3\n");
  const Finding finding = check_isolated(roots(), machine_);
  expect(finding, Verdict::kNote, "isolated: 2-3; nohz_full: 2-3");
  EXPECT_THAT(finding.lines, ElementsAre("catan run APP --cpus 2-3"));
}

TEST_F(LinuxCheckup, Governors) {
  write_cpus("cpufreq/scaling_governor", "performance\n");
  expect(check_governor(roots(), machine_), Verdict::kOk, "performance on CPUs 0-3");
  tree_.write_cpu(3, "cpufreq/scaling_governor", "powersave\n");
  const Finding finding = check_governor(roots(), machine_);
  expect(finding, Verdict::kWarning, "performance on CPUs 0-2, powersave on CPUs 3");
  EXPECT_THAT(finding.lines.front(), HasSubstr("echo performance | sudo tee"));
}

TEST_F(LinuxCheckup, GovernorsOfDriversThatGoByPreference) {
  write_cpus("cpufreq/scaling_governor", "powersave\n");
  write_cpus("cpufreq/scaling_driver", "intel_pstate\n");
  write_cpus("cpufreq/energy_performance_preference", "balance_power\n");
  expect(check_governor(roots(), machine_), Verdict::kNote, "energy preference balance_power on CPUs 0-3");
  write_cpus("cpufreq/energy_performance_preference", "performance\n");
  expect(check_governor(roots(), machine_), Verdict::kOk, "powersave");
}

TEST_F(LinuxCheckup, FrequencyLimitsAndBoost) {
  write_cpus("cpufreq/cpuinfo_max_freq", "4000000\n");
  write_cpus("cpufreq/scaling_max_freq", "4000000\n");
  expect(check_frequency_limit(roots(), machine_), Verdict::kOk, "no limit");
  tree_.write_cpu(2, "cpufreq/scaling_max_freq", "1000000\n");
  expect(check_frequency_limit(roots(), machine_), Verdict::kWarning, "CPUs 2 are held to 25 %");
  tree_.write("sys/devices/system/cpu/cpufreq/boost", "1\n");
  expect(check_boost(roots()), Verdict::kNote, "on");
  tree_.write("sys/devices/system/cpu/cpufreq/boost", "0\n");
  expect(check_boost(roots()), Verdict::kOk, "off");
}

TEST_F(LinuxCheckup, TurboOfIntel) {
  tree_.write("sys/devices/system/cpu/intel_pstate/no_turbo", "0\n");
  expect(check_boost(roots()), Verdict::kNote, "on");
  tree_.write("sys/devices/system/cpu/intel_pstate/no_turbo", "1\n");
  expect(check_boost(roots()), Verdict::kOk, "off");
}

TEST_F(LinuxCheckup, IdleStates) {
  tree_.write_cpu(0, "cpuidle/state0/latency", "1\n").write_cpu(0, "cpuidle/state1/latency", "890\n");
  tree_.write_cpu(0, "cpuidle/state1/name", "C10\n").write_cpu(0, "cpuidle/state1/disable", "0\n");
  expect(check_idle(roots(), machine_), Verdict::kNote, "up to 890 us to wake up (C10)");
  tree_.write_cpu(0, "cpuidle/state1/disable", "1\n");
  expect(check_idle(roots(), machine_), Verdict::kOk, "up to 1 us");
  machine_.keeps_ready = true;
  expect(check_idle(roots(), machine_), Verdict::kOk, "can be kept ready");
  machine_.not_ready = Error::environment("cannot keep", "be root");
  expect(check_idle(roots(), machine_), Verdict::kWarning, "cannot keep");
}

TEST_F(LinuxCheckup, Clocks) {
  const std::string folder = "sys/devices/system/clocksource/clocksource0";
  for (const std::string good : {"tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter"}) {
    tree_.write(folder + "/current_clocksource", good + "\n");
    expect(check_clock(roots()), Verdict::kOk, good);
  }
  tree_.write(folder + "/current_clocksource", "hpet\n");
  expect(check_clock(roots()), Verdict::kWarning, "hpet");
  EXPECT_THAT(check_clock(roots()).lines.front(), HasSubstr("dmesg"));
  tree_.write(folder + "/available_clocksource", "hpet tsc acpi_pm\n");
  EXPECT_THAT(check_clock(roots()).lines.front(), HasSubstr("echo tsc"));
}

TEST_F(LinuxCheckup, LateTimers) {
  expect(check_timer(machine_), Verdict::kOk, "median 20 us, p99 30 us (worst: CPU 0, p99 30 us)");
  machine_.wake_ups[2].lateness = {10us, 400us};
  expect(check_timer(machine_), Verdict::kNote, "worst: CPU 2, p99 400 us");
  machine_.wake_ups[2].lateness = {10us, 4ms};
  expect(check_timer(machine_), Verdict::kWarning, "p99 4000 us");
  machine_.level = os::Level::kOrdinary;
  expect(check_timer(machine_), Verdict::kNote, "ordinary threads");
}

TEST_F(LinuxCheckup, TimerSlackOfOrdinaryThreads) {
  tree_.write("proc/self/timerslack_ns", "50000\n");
  expect(check_timer_slack(roots(), machine_), Verdict::kOk, "50 us; ordinary threads wake up late by median 70 us");
  tree_.write("proc/self/timerslack_ns", "40000000\n");
  expect(check_timer_slack(roots(), machine_), Verdict::kNote, "40000 us");
}

TEST_F(LinuxCheckup, Preemption) {
  tree_.write("proc/version", "Linux version 6.8.0 #1 SMP PREEMPT_DYNAMIC\n");
  expect(check_preemption(roots()), Verdict::kOk, "cannot be told");
  tree_.write("proc/cmdline", "quiet preempt=none\n");
  expect(check_preemption(roots()), Verdict::kNote, "none");
  tree_.write("sys/kernel/debug/sched/preempt", "none voluntary (full) lazy\n");
  expect(check_preemption(roots()), Verdict::kOk, "full");
  tree_.write("sys/kernel/debug/sched/preempt", "none (voluntary) full\n");
  expect(check_preemption(roots()), Verdict::kNote, "voluntary");
  tree_.write("proc/version", "Linux version 6.12.0-rt #1 SMP PREEMPT_RT\n");
  expect(check_preemption(roots()), Verdict::kOk, "rt");
}

TEST_F(LinuxCheckup, Steal) {
  tree_.write("proc/stat", "cpu 1000 0 0 9000 0 0 0 0 0 0\n");
  expect(check_steal(roots(), machine_), Verdict::kOk, "0 % of CPU time since boot, 0 % while measuring");
  tree_.write("proc/stat", "cpu 1000 0 0 8950 0 0 0 50 0 0\n");
  expect(check_steal(roots(), machine_), Verdict::kNote, "0.5 %");
  tree_.write("proc/stat", "cpu 1000 0 0 8000 0 0 0 1000 0 0\n");
  expect(check_steal(roots(), machine_), Verdict::kWarning, "10 %");
  tree_.write("proc/stat", "cpu 1000 0 0 9000 0 0 0 0 0 0\n");
  machine_.stolen = 300ms;
  expect(check_steal(roots(), machine_), Verdict::kWarning, "25 % while measuring");
}

TEST(LinuxCheckupHere, AnswersAndLeavesTheThreadAsItWas) {
  const auto os = os::make_linux_os();
  const auto before = os->save_scheduling(os->current_thread());
  const auto observed = observe(*os, {});
  ASSERT_TRUE(observed.ok()) << observed.error().message();
  EXPECT_EQ(*os->save_scheduling(os->current_thread()), *before);
  for (const WakeUps& one : observed->wake_ups) EXPECT_FALSE(one.lateness.empty());
  const std::vector<Finding> findings = judge({}, *observed);
  EXPECT_EQ(findings.front().verdict == Verdict::kOk, observed->real_time.permitted);
  for (const Finding& finding : findings) expect(finding, finding.verdict, "");
}

}  // namespace
}  // namespace ctn::doctor
