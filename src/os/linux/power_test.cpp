#include "os/linux/power.h"

#include <gtest/gtest.h>

#include "os/linux/testing/fabricated_tree.h"

namespace ctn::os {
namespace {

TEST(PowerState, IsEmptyWhereTheKernelSaysNothing) {
  const FabricatedTree tree;
  EXPECT_EQ(read_power_state(tree.roots(), CpuSet{0}), (PowerState{{}, {{0, {}, ""}}}));
}

TEST(PowerState, TellsMainsFromBattery) {
  FabricatedTree tree;
  tree.write("sys/class/power_supply/AC/type", "Mains\n").write("sys/class/power_supply/AC/online", "1\n");
  tree.write("sys/class/power_supply/BAT0/type", "Battery\n").write("sys/class/power_supply/BAT0/status", "Charging\n");
  EXPECT_EQ(read_power_state(tree.roots(), {}).on_mains, true);
  tree.write("sys/class/power_supply/AC/online", "0\n");
  EXPECT_EQ(read_power_state(tree.roots(), {}).on_mains, false);
}

TEST(PowerState, ABatteryAloneTellsByItsStatus) {
  FabricatedTree tree;
  tree.write("sys/class/power_supply/BAT0/type", "Battery\n").write("sys/class/power_supply/BAT0/status", "Full\n");
  EXPECT_EQ(read_power_state(tree.roots(), {}).on_mains, true);
  tree.write("sys/class/power_supply/BAT0/status", "Discharging\n");
  EXPECT_EQ(read_power_state(tree.roots(), {}).on_mains, false);
}

TEST(PowerState, TheBatteryOfAMouseIsNotTheMachines) {
  FabricatedTree tree;
  tree.write("sys/class/power_supply/hid/type", "Battery\n")
      .write("sys/class/power_supply/hid/scope", "Device\n")
      .write("sys/class/power_supply/hid/status", "Discharging\n");
  EXPECT_FALSE(read_power_state(tree.roots(), {}).on_mains);
}

TEST(PowerState, HasTheClockLimitsOfTheCpusAskedFor) {
  FabricatedTree tree;
  for (const int cpu : {0, 1, 2}) {
    tree.write_cpu(cpu, "cpufreq/scaling_max_freq", cpu == 2 ? "nonsense\n" : "1800000\n");
    tree.write_cpu(cpu, "cpufreq/scaling_governor", "powersave\n");
  }
  const PowerState state = read_power_state(tree.roots(), CpuSet{1, 2});
  EXPECT_EQ(state.cpus, (std::vector<PowerState::Cpu>{{1, 1800000, "powersave"}, {2, {}, "powersave"}}));
}

TEST(StolenTime, IsByCpu) {
  FabricatedTree tree;
  tree.write("proc/stat",
             "cpu  9 9 9 9 9 9 9 30 0 0\ncpu0 1 1 1 1 1 1 1 12 0 0\ncpu2 1 1 1 1 1 1 1 18 0 0\ncpu3 1 1\nintr 5 4\n");
  const std::map<int, Nanos> stolen = read_stolen_time(tree.roots());
  ASSERT_EQ(stolen.size(), 2U);
  EXPECT_EQ(stolen.at(2) * 2, stolen.at(0) * 3);
  EXPECT_GT(stolen.at(0), Nanos{0});
}

}  // namespace
}  // namespace ctn::os
