#include "os/linux/topology.h"

#include <gtest/gtest.h>

#include "os/linux/linux_os.h"
#include "os/linux/testing/fabricated_tree.h"

namespace ctn::os {
namespace {

void add_cpu(FabricatedTree& tree, int cpu, int core, int package, const std::string& siblings) {
  tree.write_cpu(cpu, "topology/core_id", std::to_string(core) + "\n");
  tree.write_cpu(cpu, "topology/physical_package_id", std::to_string(package) + "\n");
  if (!siblings.empty()) tree.write_cpu(cpu, "topology/thread_siblings_list", siblings + "\n");
}

Topology read(const FabricatedTree& tree) {
  const auto topology = make_linux_os(tree.roots())->topology();
  EXPECT_TRUE(topology.ok());
  return topology.ok() ? *topology : Topology{};
}

bool same_core(const Topology& topology, std::size_t a, std::size_t b) {
  return topology.cpus[a].core == topology.cpus[b].core && topology.cpus[a].package == topology.cpus[b].package;
}

TEST(LinuxTopology, HardwareThreadsShareACore) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0-3\n");
  add_cpu(tree, 0, 0, 0, "0,2");
  add_cpu(tree, 1, 1, 0, "1,3");
  add_cpu(tree, 2, 0, 0, "0,2");
  add_cpu(tree, 3, 1, 0, "1,3");
  const Topology topology = read(tree);
  ASSERT_EQ(topology.cpus.size(), 4U);
  EXPECT_TRUE(same_core(topology, 0, 2));
  EXPECT_TRUE(same_core(topology, 1, 3));
  EXPECT_FALSE(same_core(topology, 0, 1));
}

TEST(LinuxTopology, CoreIdsServeWhereSiblingsAreNotListed) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0-2\n");
  add_cpu(tree, 0, 4, 0, "");
  add_cpu(tree, 1, 4, 0, "");
  add_cpu(tree, 2, 4, 1, "");
  const Topology topology = read(tree);
  EXPECT_TRUE(same_core(topology, 0, 1));
  EXPECT_FALSE(same_core(topology, 0, 2));
}

// ARM kernels count core_id again in each cluster: CPUs 0 and 2 are no hardware threads of one core.
TEST(LinuxTopology, CoreIdsThatRepeatByClusterMeanNothing) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0-3\n");
  for (const int cpu : {0, 1, 2, 3}) {
    add_cpu(tree, cpu, cpu % 2, 0, std::to_string(cpu));
    tree.write_cpu(cpu, "cpu_capacity", cpu < 2 ? "1024\n" : "446\n");
    tree.write_cpu(cpu, "cpufreq/cpuinfo_max_freq", cpu < 2 ? "2400000\n" : "1800000\n");
  }
  const Topology topology = read(tree);
  EXPECT_FALSE(same_core(topology, 0, 2));
  EXPECT_EQ(topology.cpus[0].capacity, 1024);
  EXPECT_EQ(topology.cpus[3].capacity, 446);
  EXPECT_EQ(topology.cpus[0].max_khz, 2400000);
}

TEST(LinuxTopology, OfflineCpusHaveNoTopologyAndNoSibling) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0,2\n");
  add_cpu(tree, 0, 0, 0, "0");
  tree.write_cpu(1, "online", "0\n");
  add_cpu(tree, 2, 1, 0, "2");
  const Topology topology = read(tree);
  ASSERT_EQ(topology.cpus.size(), 3U);
  EXPECT_FALSE(topology.cpus[1].online);
  EXPECT_EQ(topology.online(), (CpuSet{0, 2}));
  EXPECT_FALSE(same_core(topology, 0, 1));
  EXPECT_FALSE(same_core(topology, 1, 2));
}

TEST(LinuxTopology, WithoutAListTheFoldersTell) {
  FabricatedTree tree;
  add_cpu(tree, 0, 0, 0, "");  // CPU 0 often cannot go offline and has no such file
  tree.write_cpu(1, "online", "0\n").write_cpu(2, "online", "1\n").write_cpu(3, "online", "odd\n");
  EXPECT_EQ(read(tree).online(), (CpuSet{0, 2, 3}));
}

TEST(LinuxTopology, OddFilesAreAsGoodAsNone) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0-\n");
  tree.write_cpu(0, "topology/core_id", "").write_cpu(0, "topology/physical_package_id", "-1\n");
  tree.write_cpu(0, "topology/core_cpus_list", "7-3\n").write_cpu(0, "cpu_capacity", "fast\n");
  tree.write_cpu(0, "cpufreq/cpuinfo_max_freq", "0\n");
  const Topology topology = read(tree);
  ASSERT_EQ(topology.cpus.size(), 1U);
  EXPECT_TRUE(topology.cpus[0].online);
  EXPECT_EQ(topology.cpus[0].package, 0);
  EXPECT_EQ(topology.cpus[0].capacity, std::nullopt);
  EXPECT_EQ(topology.cpus[0].max_khz, std::nullopt);
}

TEST(LinuxTopology, WithoutFilesOnlyTheListSpeaks) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0-1\n");
  const Topology topology = read(tree);
  EXPECT_EQ(topology.online(), (CpuSet{0, 1}));
  EXPECT_FALSE(same_core(topology, 0, 1));
}

TEST(LinuxTopology, NothingAtAllIsAnError) {
  const FabricatedTree tree;
  const auto topology = make_linux_os(tree.roots())->topology();
  ASSERT_FALSE(topology.ok());
  EXPECT_EQ(topology.error().kind(), ErrorKind::kEnvironment);
}

TEST(LinuxTopology, ManyCpus) {
  FabricatedTree tree;
  tree.write("sys/devices/system/cpu/online", "0-2047\n");
  EXPECT_EQ(read(tree).online().size(), 2048U);
}

// One system is asked several times a second, and keeps the list open.
TEST(LinuxTopology, CpusThatGoAndComeBackAreSeenByOneWhoAsksAgain) {
  FabricatedTree tree;
  const std::unique_ptr<Os> os = make_linux_os(tree.roots());
  for (const auto& [list, cpus] : std::vector<std::pair<std::string, CpuSet>>{{"0-3\n", {0, 1, 2, 3}},
                                                                              {"0-3\n", {0, 1, 2, 3}},
                                                                              {"0,2-3\n", {0, 2, 3}},
                                                                              {"1\n", {1}},
                                                                              {"0-3\n", {0, 1, 2, 3}}}) {
    tree.write("sys/devices/system/cpu/online", list);
    const Result<CpuSet> online = os->online_cpus();
    ASSERT_TRUE(online.ok()) << list;
    EXPECT_EQ(*online, cpus) << list;
  }
  std::string evens = "0";
  std::vector<int> numbers{0};
  for (int cpu = 2; cpu < 400; cpu += 2) {
    evens += "," + std::to_string(cpu);
    numbers.push_back(cpu);
  }
  tree.write("sys/devices/system/cpu/online", evens + "\n");
  const Result<CpuSet> online = os->online_cpus();
  ASSERT_TRUE(online.ok());
  EXPECT_EQ(*online, CpuSet(numbers)) << "longer than what is read at once";
}

}  // namespace
}  // namespace ctn::os
