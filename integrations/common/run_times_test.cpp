#include "common/run_times.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace catan_ros {
namespace {

TEST(RunTimes, ATimeWithinARunIsItsOwn) {
  const auto times = RunTimes::open({});
  ASSERT_NE(times, nullptr);
  EXPECT_EQ(times->find("camera", 100), 0U) << "nothing is known of it";
  times->begin("camera", 1, 100);
  EXPECT_EQ(times->find("camera", 99), 0U);
  EXPECT_EQ(times->find("camera", 100), 1U);
  EXPECT_EQ(times->find("camera", 1'000'000), 1U) << "it is under way";
  times->end("camera", 200);
  EXPECT_EQ(times->find("camera", 200), 1U);
  EXPECT_EQ(times->find("camera", 201), 0U) << "between two runs";
  times->begin("camera", 2, 300);
  EXPECT_EQ(times->find("camera", 150), 1U);
  EXPECT_EQ(times->find("camera", 250), 0U);
  EXPECT_EQ(times->find("camera", 301), 2U);
  EXPECT_EQ(times->find("lidar", 301), 0U) << "another node";
}

TEST(RunTimes, TheLastRunsAreKept) {
  const auto times = RunTimes::open({});
  const auto runs = static_cast<std::int64_t>(2 * RunTimes::kRuns);
  for (std::int64_t run = 1; run <= runs; ++run) {
    times->begin("camera", static_cast<std::uint64_t>(run), 10 * run);
    times->end("camera", 10 * run + 5);
  }
  for (std::int64_t run = 1; run <= runs; ++run) {
    const bool kept = run > runs - static_cast<std::int64_t>(RunTimes::kRuns);
    EXPECT_EQ(times->find("camera", 10 * run + 1), kept ? static_cast<std::uint64_t>(run) : 0U);
  }
}

TEST(RunTimes, ProgramsShareAFile) {
  const std::string path = testing::TempDir() + "run_times";
  static_cast<void>(std::remove(path.c_str()));
  const auto writer = RunTimes::open(path);
  const auto reader = RunTimes::open(path);
  ASSERT_NE(writer, nullptr);
  ASSERT_NE(reader, nullptr);
  writer->begin("camera", 7, 100);
  EXPECT_EQ(reader->find("camera", 100), 7U);
  EXPECT_EQ(RunTimes::open(testing::TempDir()), nullptr) << "a folder";
}

}  // namespace
}  // namespace catan_ros
