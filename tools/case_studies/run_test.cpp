#include "run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <limits>

namespace ctn::case_studies {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;
using ::testing::Pair;

const char* const kStored = R"({"map": "1", "seed": 7, "figures": {"collided": 1.0, "goal_s": null},
  "staleness_ms_p95_by_5s": [10.0, null, 30.0], "contacts": [{"at_s": 1}], "cpus": [1], "in_common": ["map"]})";

StoredRun with(std::uint64_t seed, ByTime list) { return {seed, {}, {{"x_by_1s", std::move(list)}}}; }

TEST(ParseRun, TakesFiguresAndWhatIsOverTime) {
  const auto run = parse_run(kStored, "f");
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run->seed, 7U);
  EXPECT_THAT(run->figure("collided"), Optional(1.0));
  EXPECT_FALSE(run->figure("goal_s"));
  EXPECT_FALSE(run->figure("no such"));
  ASSERT_EQ(run->by_time.size(), 1U) << "no other list is over time";
  EXPECT_THAT(run->options, ElementsAre(Pair("map", "\"1\""))) << "nothing else, and no seed";
  EXPECT_THAT(run->by_time.at("staleness_ms_p95_by_5s"), ElementsAre(Optional(10.0), std::nullopt, Optional(30.0)));
}

// It once depended on the order of members which of them were options.
TEST(ParseRun, OptionsAreThoseThatTheRunNamesWhereverTheyAre) {
  const auto run = parse_run(R"({"in_common": ["seconds", "inputs", "real_time"], "cores": 1, "figures": {},
      "real_time": true, "inputs": {"app": "11"}, "seconds": 3.0, "seed": 7})",
                             "f");
  ASSERT_TRUE(run.ok());
  EXPECT_THAT(run->options,
              ElementsAre(Pair("inputs.app", "\"11\""), Pair("real_time", "true"), Pair("seconds", "3.0")));
  EXPECT_FALSE(parse_run(R"({"figures": {}, "seed": 7, "cores": 1})", "f").ok()) << "it names none";
}

TEST(ParseRun, NamesTheFileThatIsNone) {
  for (const char* text : {"", "[]", "{}", R"({"figures": {}})", R"({"figures": 3, "seed": 1})"}) {
    const auto run = parse_run(text, "there/run-1.json");
    ASSERT_FALSE(run.ok()) << text;
    EXPECT_THAT(run.error().message(), HasSubstr("there/run-1.json"));
  }
}

TEST(ReadRuns, TakesThoseThatAreThere) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("runs_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  for (const int seed : {6, 7, 9}) std::ofstream(folder / ("run-" + std::to_string(seed) + ".json")) << kStored;
  EXPECT_EQ(read_runs(folder, 7, 2)->size(), 1U) << "6 and 9 are not asked for, 8 is not there";
  EXPECT_EQ(read_runs(folder, 6, 4)->size(), 3U);
  EXPECT_TRUE(read_runs(folder / "nowhere", 1, 3)->empty());
  std::ofstream(folder / "run-8.json") << "half a f";
  EXPECT_FALSE(read_runs(folder, 6, 4).ok());
  std::filesystem::remove_all(folder);
}

TEST(MediansByTime, EndWhereHalfOfTheRunsHave) {
  const std::vector<StoredRun> runs{with(1, {1.0, 5.0, std::nullopt, 7.0}), with(2, {2.0, 6.0, std::nullopt}),
                                    with(3, {9.0})};
  EXPECT_THAT(medians_by_time(runs, "x_by_1s"), ElementsAre(Optional(2.0), Optional(5.0), std::nullopt));
  EXPECT_TRUE(medians_by_time(runs, "y_by_1s").empty());
  EXPECT_TRUE(medians_by_time({}, "x_by_1s").empty());
}

TEST(MediansByTime, CountWhatStarvesWhereTheyCompare) {
  const double never = std::numeric_limits<double>::infinity();
  const std::vector<StoredRun> runs{with(1, {1.0, 5.0}), with(2, {std::nullopt, std::nullopt}),
                                    with(3, {2.0, std::nullopt})};
  EXPECT_THAT(medians_by_time(runs, "x_by_1s"), ElementsAre(Optional(1.0), Optional(5.0)));
  EXPECT_THAT(medians_with_never(runs, "x_by_1s"), ElementsAre(Optional(2.0), Optional(never)));
}

TEST(MediansByTime, OfPeriodsKnowThatOneMaySpanStretches) {
  const double never = std::numeric_limits<double>::infinity();
  const std::optional<double> none;
  EXPECT_THAT(medians_of_periods({with(1, {none, 3.0, none, 9.0, none})}, "x_by_1s"),
              ElementsAre(Optional(3.0), Optional(3.0), Optional(9.0), Optional(9.0), Optional(9.0)));
  EXPECT_THAT(medians_of_periods({with(1, {none, none})}, "x_by_1s"), ElementsAre(Optional(never), Optional(never)));
}

TEST(MeanBetween, IsOfAPartOfTheRun) {
  const StoredRun run = with(1, {1.0, 2.0, std::nullopt, 10.0});
  EXPECT_THAT(mean_between(run, "x_by_1s", 0.0, 0.5), Optional(1.5));
  EXPECT_THAT(mean_between(run, "x_by_1s", 0.5, 1.0), Optional(10.0));
  EXPECT_FALSE(mean_between(run, "x_by_1s", 0.5, 0.75));
  EXPECT_FALSE(mean_between(run, "y_by_1s", 0.0, 1.0));
}

}  // namespace
}  // namespace ctn::case_studies
