#include "os/linux/idle.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "os/linux/testing/fabricated_tree.h"

namespace ctn::os {
namespace {

constexpr const char* kDriver = "sys/devices/system/cpu/cpuidle/current_driver";

TEST(KeepCpusReady, LeavesRealHardwareToItsSettings) {
  FabricatedTree tree;
  EXPECT_EQ(keep_cpus_ready(tree.roots()).value(), nullptr) << "no idle driver";
  tree.write(kDriver, "intel_idle\n").write("dev/cpu_dma_latency", "");
  EXPECT_EQ(keep_cpus_ready(tree.roots()).value(), nullptr);
  EXPECT_EQ(read_text(tree.roots().devices + "/cpu_dma_latency"), "");
}

TEST(KeepCpusReady, HoldsAZeroWakeUpLatencyInAVirtualMachine) {
  FabricatedTree tree;
  tree.write(kDriver, "haltpoll\n").write("dev/cpu_dma_latency", "");
  const auto held = keep_cpus_ready(tree.roots());
  ASSERT_TRUE(held.ok());
  ASSERT_NE(*held, nullptr);
  const std::optional<std::string> written = read_text(tree.roots().devices + "/cpu_dma_latency");
  EXPECT_EQ(written, std::string(sizeof(std::int32_t), '\0'));
}

TEST(KeepCpusReady, SaysWhatToDoWhereItIsRefused) {
  FabricatedTree tree;
  tree.write(kDriver, "haltpoll\n");
  const auto held = keep_cpus_ready(tree.roots());
  ASSERT_FALSE(held.ok());
  EXPECT_EQ(held.error().kind(), ErrorKind::kEnvironment);
  EXPECT_NE(held.error().message().find("cpu_dma_latency"), std::string::npos);
}

}  // namespace
}  // namespace ctn::os
