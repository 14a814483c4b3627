#include "alike.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ctn::case_studies {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// As a program stores it.
StoredRun made_with(int seed, const std::string& seconds, const std::string& world = "aa") {
  const auto run = parse_run(R"({"map": "mine.yaml", "scheduler": "catan", "stealing": true, "seconds": )" + seconds +
                                 R"(, "seed": )" + std::to_string(seed) + R"(, "mover_speed": 0.5,
                                 "inputs": {"app": "11", "world": ")" +
                                 world + R"("}, "calibration": {"LP": 1.)" + std::to_string(seed) + R"(},
                                 "cpus": [3], "in_common": ["map", "scheduler", "stealing", "seconds", "mover_speed",
                                 "inputs", "cpus"], "ended_by": ")" +
                                 std::to_string(seed) + R"(", "figures": {}})",
                             "f");
  EXPECT_TRUE(run.ok());
  return *run;
}

// As a program says it.
RunOptions asked(const std::string& text) {
  const auto options = parse_options(text);
  EXPECT_TRUE(options) << text;
  return options.value_or(RunOptions{});
}

RunOptions asked() {
  return asked(R"({"scheduler": "catan", "seconds": 90, "mover_speed": 0.50, "cpus": [3], "camera": 20})");
}

TEST(Alike, SeedsAndHowRunsEndedMayDiffer) {
  const Alike all = alike({made_with(1, "90.0"), made_with(2, "90.0")}, asked());
  EXPECT_THAT(all.runs, SizeIs(2));
  EXPECT_EQ(all.left_out, "");
}

// A page once had medians over runs of 3 s and of 90 s.
TEST(Alike, RunsWithOtherOptionsThanTheBatchAreLeftOut) {
  const Alike some = alike({made_with(1, "3.0"), made_with(2, "90.0")}, asked());
  ASSERT_THAT(some.runs, SizeIs(1));
  EXPECT_EQ(some.runs[0].seed, 2U);
  EXPECT_THAT(some.left_out, AllOf(HasSubstr("1 of 2"), HasSubstr("run-1.json"), HasSubstr("seconds (3.0, not 90)")));
  EXPECT_THAT(alike({made_with(1, "90.0")}, asked(R"({"scheduler": "default"})")).runs, IsEmpty());
  EXPECT_THAT(alike({made_with(1, "90.0")}, asked(R"({"stealing": false})")).runs, IsEmpty());
  EXPECT_THAT(alike({made_with(1, "90.0")}, asked(R"({"cpus": [1]})")).runs, IsEmpty());
}

TEST(Alike, OfRunsThatDifferNoneIsTaken) {
  const Alike none = alike({made_with(1, "3.0"), made_with(2, "90.0")}, {});
  EXPECT_THAT(none.runs, IsEmpty());
  EXPECT_THAT(none.left_out, AllOf(HasSubstr("run-1.json and run-2.json"), HasSubstr("seconds (90.0, not 3.0)")));
  const Alike worlds = alike({made_with(1, "90.0"), made_with(2, "90.0"), made_with(3, "90.0", "bb")}, asked());
  EXPECT_THAT(worlds.runs, IsEmpty());
  EXPECT_THAT(worlds.left_out, HasSubstr("inputs.world (bb, not aa)"));
}

TEST(Alike, OfAMapThatHasChangedTheNewRunsAreTaken) {
  const StoredRun old = made_with(1, "90.0");
  const StoredRun fresh = made_with(2, "90.0", "new");
  const Alike some = alike({old, fresh}, asked(R"({"map": "mine.yaml", "inputs": {"world": "new"}})"));
  ASSERT_THAT(some.runs, SizeIs(1));
  EXPECT_EQ(some.runs[0].seed, 2U);
}

}  // namespace
}  // namespace ctn::case_studies
