#include "alike.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "program/fingerprint.h"

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
                                 "cpus": [3], "ended_by": ")" +
                                 std::to_string(seed) + R"(", "figures": {}})",
                             "f");
  EXPECT_TRUE(run.ok());
  return *run;
}

const std::vector<std::string> kAsked{"--scheduler", "catan",  "--seconds", "90",       "--mover-speed",
                                      "0.50",        "--cpus", "3",         "--camera", "20"};

TEST(Alike, SeedsAndHowRunsEndedMayDiffer) {
  const Alike all = alike({made_with(1, "90.0"), made_with(2, "90.0")}, kAsked);
  EXPECT_THAT(all.runs, SizeIs(2));
  EXPECT_EQ(all.left_out, "");
}

// A page once had medians over runs of 3 s and of 90 s.
TEST(Alike, RunsWithOtherOptionsThanTheBatchAreLeftOut) {
  const Alike some = alike({made_with(1, "3.0"), made_with(2, "90.0")}, kAsked);
  ASSERT_THAT(some.runs, SizeIs(1));
  EXPECT_EQ(some.runs[0].seed, 2U);
  EXPECT_THAT(some.left_out, AllOf(HasSubstr("1 of 2"), HasSubstr("run-1.json"), HasSubstr("seconds (3.0, not 90)")));
  EXPECT_THAT(alike({made_with(1, "90.0")}, {"--scheduler", "default"}).runs, IsEmpty());
  EXPECT_THAT(alike({made_with(1, "90.0")}, {"--no-stealing"}).runs, IsEmpty());
  EXPECT_THAT(alike({made_with(1, "90.0")}, {"--cpus", "1"}).runs, IsEmpty());
}

TEST(Alike, OfRunsThatDifferNoneIsTaken) {
  const Alike none = alike({made_with(1, "3.0"), made_with(2, "90.0")}, {});
  EXPECT_THAT(none.runs, IsEmpty());
  EXPECT_THAT(none.left_out, AllOf(HasSubstr("run-1.json and run-2.json"), HasSubstr("seconds (90.0, not 3.0)")));
  const Alike worlds = alike({made_with(1, "90.0"), made_with(2, "90.0"), made_with(3, "90.0", "bb")}, kAsked);
  EXPECT_THAT(worlds.runs, IsEmpty());
  EXPECT_THAT(worlds.left_out, HasSubstr("inputs.world (bb, not aa)"));
}

TEST(Alike, OfAMapThatHasChangedTheNewRunsAreTaken) {
  const std::filesystem::path map =
      std::filesystem::path(::testing::TempDir()) / ("alike_" + std::to_string(getpid()) + ".yaml");
  std::ofstream(map) << "new";
  program::Fingerprint fingerprint;
  fingerprint.add("new");
  StoredRun old = made_with(1, "90.0");
  StoredRun fresh = made_with(2, "90.0", fmt::format("{:016x}", fingerprint.value()));
  old.options["map"] = fresh.options["map"] = map.string();
  const Alike some = alike({old, fresh}, {"--map", map.string()});
  std::filesystem::remove(map);
  ASSERT_THAT(some.runs, SizeIs(1));
  EXPECT_EQ(some.runs[0].seed, 2U);
}

}  // namespace
}  // namespace ctn::case_studies
