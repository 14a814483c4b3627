#include "os/linux/facts.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "os/linux/linux_os.h"
#include "os/linux/privilege.h"
#include "os/linux/testing/fabricated_tree.h"

namespace ctn::os {
namespace {

FabricatedTree& write_kernel(FabricatedTree& tree, const std::string& release) {
  return tree.write("proc/sys/kernel/osrelease", release + "\n");
}

FabricatedTree& write_throttling(FabricatedTree& tree, const std::string& runtime, const std::string& period) {
  return tree.write("proc/sys/kernel/sched_rt_runtime_us", runtime + "\n")
      .write("proc/sys/kernel/sched_rt_period_us", period + "\n");
}

FabricatedTree& write_fair_server(FabricatedTree& tree, int cpu, const std::string& runtime) {
  const std::string folder = "sys/kernel/debug/sched/fair_server/cpu" + std::to_string(cpu);
  return tree.write(folder + "/runtime", runtime + "\n").write(folder + "/period", "1000000000\n");
}

void expect_reserve(const FabricatedTree& tree, double fraction, const std::string& by) {
  const Reserve reserve = read_reserve(tree.roots());
  EXPECT_NEAR(reserve.fraction, fraction, 1e-12);
  EXPECT_EQ(reserve.by, by);
  const RealTimeFacts facts = make_linux_os(tree.roots())->real_time_facts();
  EXPECT_EQ(facts.reserved, reserve.fraction);
  EXPECT_EQ(facts.reserved_by, reserve.by);
}

TEST(LinuxReserve, OlderKernelsThrottle) {
  FabricatedTree tree;
  write_throttling(write_kernel(tree, "6.8.0-45-generic"), "900000", "1000000");
  expect_reserve(tree, 0.1, "throttling");
}

TEST(LinuxReserve, ThrottlingThatIsOffReservesNothing) {
  FabricatedTree tree;
  write_throttling(write_kernel(tree, "5.15.0"), "-1", "1000000");
  expect_reserve(tree, 0.0, "nothing");
  write_throttling(tree, "1000000", "1000000");
  expect_reserve(tree, 0.0, "nothing");
}

TEST(LinuxReserve, NewKernelsHaveAFairServerWhateverThrottlingSays) {
  FabricatedTree tree;
  for (const char* release : {"6.12.0", "6.18.44-custom", "7.0-rc1", "10.2"}) {
    write_throttling(write_kernel(tree, release), "-1", "1000000");
    expect_reserve(tree, 0.05, "fair server (assumed default)");
  }
}

TEST(LinuxReserve, FairServerIsReadWhereItCanBe) {
  FabricatedTree tree;
  write_throttling(write_kernel(tree, "6.14.2"), "-1", "1000000");
  write_fair_server(write_fair_server(tree, 0, "30000000"), 1, "70000000");
  expect_reserve(tree, 0.07, "fair server");
  write_fair_server(write_fair_server(tree, 0, "0"), 1, "0");
  expect_reserve(tree, 0.0, "nothing");
}

TEST(LinuxReserve, TheLargerOfTwoCounts) {
  FabricatedTree tree;
  write_throttling(write_kernel(tree, "6.14.2"), "800000", "1000000");
  expect_reserve(tree, 0.2, "throttling");
  write_throttling(tree, "950000", "1000000");
  expect_reserve(tree, 0.05, "fair server (assumed default)");
}

TEST(LinuxReserve, AControlGroupMayThrottleHarder) {
  FabricatedTree tree;
  write_throttling(write_kernel(tree, "6.8.0"), "950000", "1000000");
  tree.write("proc/self/cgroup", "4:memory:/x\n3:cpu,cpuacct:/robot\n0::/\n");
  tree.write("sys/fs/cgroup/cpu,cpuacct/robot/cpu.rt_runtime_us", "300000\n");
  tree.write("sys/fs/cgroup/cpu,cpuacct/robot/cpu.rt_period_us", "500000\n");
  expect_reserve(tree, 0.4, "throttling");
}

TEST(LinuxReserve, OddFilesMeanTheDefault) {
  FabricatedTree tree;
  write_throttling(write_kernel(tree, "6.8.0"), "much", "1000000");
  expect_reserve(tree, 0.05, "throttling (assumed default)");
  write_throttling(tree, "950000", "0");
  expect_reserve(tree, 0.05, "throttling (assumed default)");
  write_throttling(write_kernel(tree, "next"), "-1", "1000000");
  expect_reserve(tree, 0.05, "fair server (assumed default)");
  write_fair_server(tree, 0, "odd");
  expect_reserve(tree, 0.05, "fair server (assumed default)");
}

TEST(LinuxPrivilege, CgroupWithoutRealTimeTimeIsNamed) {
  FabricatedTree tree;
  tree.write("proc/self/cgroup", "1:cpu:/robot\n");
  tree.write("sys/fs/cgroup/cpu/robot/cpu.rt_runtime_us", "0\n");
  EXPECT_NE(how_to_permit(tree.roots()).find("/robot/cpu.rt_runtime_us"), std::string::npos);
}

TEST(LinuxPrivilege, CgroupOfAContainerIsItsMount) {
  FabricatedTree tree;
  tree.write("proc/self/cgroup", "1:cpu:/path/on/the/host\n");
  tree.write("sys/fs/cgroup/cpu/cpu.rt_runtime_us", "0\n");
  const auto cgroup = real_time_cgroup(tree.roots());
  ASSERT_TRUE(cgroup);
  EXPECT_EQ(cgroup->runtime_us, 0);
}

TEST(LinuxPrivilege, WithoutTheCapabilityItIsNamed) {
  FabricatedTree tree;
  tree.write("proc/self/status", "Name:\tx\nCapEff:\t0000000000000000\n");
  const std::string hint = how_to_permit(tree.roots());
  EXPECT_NE(hint.find("setcap cap_sys_nice+ep"), std::string::npos);
  EXPECT_NE(hint.find("limits.conf"), std::string::npos);
}

TEST(LinuxPrivilege, WithTheCapabilitySomethingElseForbids) {
  FabricatedTree tree;
  tree.write("proc/self/status", "CapEff:\t0000000000800000\n");
  EXPECT_NE(how_to_permit(tree.roots()).find("something else"), std::string::npos);
}

TEST(LinuxPrivilege, OddFilesStillGiveAnAnswer) {
  FabricatedTree tree;
  tree.write("proc/self/cgroup", ":\n1:cpu\n::\n2:cpu:/gone\n").write("proc/self/status", "CapEff:\tnone\n");
  EXPECT_FALSE(how_to_permit(tree.roots()).empty());
  EXPECT_FALSE(how_to_permit({"/nowhere", "/nowhere"}).empty());
}

TEST(LinuxHostFacts, ReadsWhatIsThere) {
  FabricatedTree tree;
  tree.write("proc/cpuinfo", "processor\t: 0\nmodel name\t: Quick CPU\n");
  tree.write("proc/stat", "cpu  1 2 3 4 5 6 7 250 0 0\ncpu0 1 2 3 4 5 6 7 999 0 0\n");
  tree.write("sys/devices/system/cpu/online", "0-1\n");
  tree.write_cpu(0, "cpufreq/scaling_governor", "performance\n");
  tree.write_cpu(1, "cpufreq/scaling_governor", "powersave\n");
  tree.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
  const HostFacts facts = read_host_facts(tree.roots());
  EXPECT_NE(facts.kernel.find("Linux"), std::string::npos);
  EXPECT_EQ(facts.cpu_model, "Quick CPU");
  EXPECT_EQ(facts.governor, "performance,powersave");
  EXPECT_EQ(facts.clock_source, "tsc");
  EXPECT_EQ(facts.cpu_count, 2);
  EXPECT_EQ(facts.steal, Nanos{1'000'000'000 / ::sysconf(_SC_CLK_TCK)} * 250);
}

TEST(LinuxHostFacts, ArmBoardsNameThemselvesElsewhere) {
  FabricatedTree tree;
  tree.write("proc/cpuinfo", "processor\t: 0\nCPU part\t: 0xd0b\n");
  tree.write("sys/firmware/devicetree/base/model", std::string("Orin Nano\0", 10));
  EXPECT_EQ(read_host_facts(tree.roots()).cpu_model, "Orin Nano");
}

TEST(LinuxHostFacts, MissingAndOddFilesLeaveFactsEmpty) {
  FabricatedTree tree;
  for (const char* stat : {"", "cpu 1 2 3\n", "intr 1 2 3 4 5 6 7 8\n", "cpu 1 2 3 4 5 6 7 -8\n", "cpu a b\n",
                           "cpu 1 2 3 4 5 6 7 999999999999\n", "cpu 1 2 3 4 5 6 7 9999999999999999999\n"}) {
    tree.write("proc/stat", stat);
    const HostFacts facts = read_host_facts(tree.roots());
    EXPECT_EQ(facts.steal, Nanos{0}) << stat;
    EXPECT_EQ(facts.cpu_model, "");
    EXPECT_EQ(facts.governor, "");
    EXPECT_EQ(facts.cpu_count, 0);
  }
}

}  // namespace
}  // namespace ctn::os
