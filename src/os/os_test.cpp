#include "os/os.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace ctn::os {
namespace {

CpuSet parsed(const std::string& text) {
  const auto cpus = parse_cpu_list(text);
  EXPECT_TRUE(cpus.ok()) << text << ": " << (cpus.ok() ? "" : cpus.error().message());
  return cpus.ok() ? *cpus : CpuSet{};
}

TEST(CpuSet, IsSortedWithoutDoubles) {
  const CpuSet cpus{3, 1, 3, 0};
  EXPECT_EQ(cpus.cpus(), (std::vector<int>{0, 1, 3}));
  EXPECT_TRUE(cpus.contains(3));
  EXPECT_FALSE(cpus.contains(2));
}

TEST(CpuList, ReadsWhatLinuxWrites) {
  EXPECT_EQ(parsed("0-3,5\n"), (CpuSet{0, 1, 2, 3, 5}));
  EXPECT_EQ(parsed("7"), CpuSet{7});
  EXPECT_EQ(parsed(""), CpuSet{});
  EXPECT_EQ(parsed("\n"), CpuSet{});
  EXPECT_EQ(parsed("2,0-1,1-2"), (CpuSet{0, 1, 2}));
}

TEST(CpuList, RefusesAllElseAsTheCallersMistake) {
  for (const char* text : {",", "0,", ",0", "0,,1", "1-", "-1", "3-1", "a", "0x1", "1 2", "0-3:2", "65536",
                           "0-99999999999", "--1", "1--2", "+1"}) {
    const auto cpus = parse_cpu_list(text);
    ASSERT_FALSE(cpus.ok()) << text;
    EXPECT_EQ(cpus.error().kind(), ErrorKind::kCaller);
    EXPECT_NE(cpus.error().message().find("0-3,5"), std::string::npos) << cpus.error().message();
  }
}

TEST(CpuList, WritesTheShortestRanges) {
  EXPECT_EQ(to_string(CpuSet{0, 1, 2, 3, 5}), "0-3,5");
  EXPECT_EQ(to_string(CpuSet{0, 1}), "0-1");
  EXPECT_EQ(to_string(CpuSet{}), "");
}

TEST(CpuList, OverlapsOfHugeRangesStaySmall) {
  std::string text = "0-65535";
  for (int i = 0; i < 20; ++i) text += ",0-65535";
  EXPECT_EQ(parsed(text).size(), 65536U);
}

RC_GTEST_PROP(CpuList, ReadsBackWhatItWrote, ()) {
  const CpuSet cpus(*rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 300)));
  const auto again = parse_cpu_list(to_string(cpus));
  RC_ASSERT(again.ok());
  RC_ASSERT(*again == cpus);
}

TEST(Topology, OnlineLeavesOutWhatIsNot) {
  Topology topology;
  for (const int number : {0, 1, 2}) {
    Cpu cpu;
    cpu.number = number;
    cpu.online = number != 1;
    topology.cpus.push_back(cpu);
  }
  EXPECT_EQ(topology.online(), (CpuSet{0, 2}));
}

TEST(Level, HasNames) {
  EXPECT_STREQ(to_string(Level::kOrdinary), "ordinary");
  EXPECT_STREQ(to_string(Level::kDispatcher), "dispatcher");
  EXPECT_LT(Level::kBackground, Level::kActive);
}

}  // namespace
}  // namespace ctn::os
