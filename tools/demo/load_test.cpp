#include "load.h"

#include <gtest/gtest.h>

namespace ctn::demo {
namespace {

const char* const kStat = "cpu  100 20 30 4000 50 6 7 8 9 10\ncpu0 1 2 3\n";
const char* const kSelf = "42 (a name) with) S 1 2 3 4 5 6 7 8 9 10 11 12 13 14 20 0 1\n";

TEST(CpuTimes, AreReadAsTheKernelWritesThem) {
  const auto times = parse_cpu_times(kStat, kSelf);
  ASSERT_TRUE(times.has_value());
  EXPECT_EQ(times->busy, 100 + 20 + 30 + 6 + 7 + 8);
  EXPECT_EQ(times->total, times->busy + 4050);
  EXPECT_EQ(times->ours, 11 + 12 + 13 + 14);
}

TEST(CpuTimes, AreNothingWhereTheTextIsOdd) {
  EXPECT_FALSE(parse_cpu_times("", kSelf));
  EXPECT_FALSE(parse_cpu_times("cpu 1 2", kSelf));
  EXPECT_FALSE(parse_cpu_times(kStat, "42"));
  EXPECT_FALSE(parse_cpu_times(kStat, "42 (x) S 1 2"));
}

TEST(OthersShare, IsWhatIsNeitherIdleNorOurs) {
  EXPECT_DOUBLE_EQ(others_share(CpuTimes{0, 0, 0}, CpuTimes{600, 1000, 500}), 0.1);
  EXPECT_EQ(others_share(CpuTimes{0, 0, 0}, CpuTimes{600, 1000, 700}), 0.0);
  EXPECT_EQ(others_share(std::nullopt, CpuTimes{600, 1000, 500}), 0.0);
  EXPECT_TRUE(read_cpu_times().has_value());
}

}  // namespace
}  // namespace ctn::demo
