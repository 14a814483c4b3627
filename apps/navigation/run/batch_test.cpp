#include "run/batch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

class BatchTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) / ("navigation_batch_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Options options(int runs) const {
    Options options;
    options.virtual_time = true;
    options.seed = 5;
    options.runs = runs;
    options.out = folder_.string();
    return options;
  }
  // A run with as many contacts and metres as its seed says.
  Result<Outcome> run_one(const Options& options) {
    seeds_.push_back(options.seed);
    Outcome outcome;
    outcome.options = options;
    outcome.findings.way = static_cast<double>(options.seed);
    outcome.findings.contacts.resize(options.seed % 2);
    outcome.findings.lasted = 7s;
    outcome.findings.guidance_ages = {{1s, std::chrono::milliseconds(10 * options.seed)}};
    outcome.snapshot.real_time = real_time_;
    if (options.seed == signal_at_) outcome.signal = 15;
    return outcome;
  }
  Result<Batch> run(const Options& options) {
    return run_batch(
        options, [this](const Options& one) { return run_one(one); },
        [this](const std::string& line) { lines_.push_back(line); });
  }

  std::filesystem::path folder_;
  std::vector<std::uint64_t> seeds_;
  std::vector<std::string> lines_;
  std::uint64_t signal_at_ = 0;
  bool real_time_ = false;
};

TEST_F(BatchTest, GoesOnWhereItStopped) {
  signal_at_ = 7;
  const auto stopped = run(options(4));
  ASSERT_TRUE(stopped.ok());
  EXPECT_EQ(stopped->signal, 15);
  EXPECT_EQ(stopped->runs.size(), 2U);
  EXPECT_THAT(seeds_, ElementsAre(5, 6, 7));

  signal_at_ = 0;
  seeds_.clear();
  const auto finished = run(options(4));
  ASSERT_TRUE(finished.ok());
  EXPECT_THAT(seeds_, ElementsAre(7, 8)) << "5 and 6 were there";
  EXPECT_EQ(finished->signal, 0);

  seeds_.clear();
  const auto again = run(options(4));
  ASSERT_TRUE(again.ok());
  EXPECT_THAT(seeds_, ElementsAre());
  EXPECT_EQ(to_json(*again), to_json(*finished));
  EXPECT_EQ(lines_.size(), 2U + 4U + 4U);
}

TEST_F(BatchTest, DoesNotMixRunsWithOtherOptions) {
  ASSERT_TRUE(run(options(2)).ok());
  Options other = options(2);
  other.scheduler = "default";
  const auto refused = run(other);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(refused.error().message().find("scheduler"), std::string::npos);
  Options with_other_app = options(2);
  with_other_app.inputs["app"] = "another";
  EXPECT_FALSE(run(with_other_app).ok()) << "of files with other contents";
  std::ofstream(folder_ / "run-5.json") << "{";
  EXPECT_FALSE(run(options(2)).ok()) << "what is no outcome is not taken for one";
}

// In life, runs with privileges and runs without went into one batch.
TEST_F(BatchTest, DoesNotMixRunsWithAndWithoutRealTimeLevels) {
  Options live = options(2);
  live.virtual_time = false;
  real_time_ = true;
  ASSERT_TRUE(run(live).ok());
  live.runs = 3;
  real_time_ = false;
  const auto refused = run(live);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(refused.error().message().find("real_time"), std::string::npos) << refused.error().message();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run-7.json")) << "it is not stored among the others";
  std::filesystem::remove(folder_ / "run-5.json");
  EXPECT_FALSE(run(live).ok()) << "nor in front of them";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run-5.json"));
  real_time_ = true;
  const auto finished = run(live);
  ASSERT_TRUE(finished.ok());
  EXPECT_EQ(finished->runs.size(), 3U);
}

TEST_F(BatchTest, SaysWhereAFolderCannotBe) {
  Options nowhere = options(1);
  nowhere.out = "/proc/nowhere";
  const auto refused = run(nowhere);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind(), ErrorKind::kEnvironment);
}

TEST_F(BatchTest, HasMediansAndSpread) {
  const auto batch = run(options(4));  // seeds 5 to 8
  ASSERT_TRUE(batch.ok());
  const auto json = nlohmann::json::parse(to_json(*batch));
  EXPECT_EQ(json["runs"].size(), 4U);
  EXPECT_EQ(json["runs"][0]["seed"], 5);
  const auto& way = json["summary"]["way_m"];
  EXPECT_EQ(way["count"], 4);
  EXPECT_EQ(way["mean"], 6.5);
  EXPECT_EQ(way["min"], 5.0);
  EXPECT_EQ(way["lower_quartile"], 5.0);
  EXPECT_EQ(way["median"], 6.0);
  EXPECT_EQ(way["upper_quartile"], 7.0);
  EXPECT_EQ(way["max"], 8.0);
  EXPECT_EQ(json["summary"]["collided"]["mean"], 0.5);
  EXPECT_EQ(json["summary"]["goal_s"]["count"], 0);
  EXPECT_THAT(medians_by_time(batch->runs, &StoredRun::staleness), ElementsAre(60.0, std::nullopt));
  EXPECT_NE(to_text(*batch).find("2 with a collision"), std::string::npos);
  EXPECT_NE(to_text(*batch).find("staleness_ms_p95 by 5 s, medians\n       0 s      60.0        -\n"),
            std::string::npos);
}

TEST(MediansByTime, AreOfTheRunsThatLastedSoLong) {
  std::vector<StoredRun> runs(3);
  runs[0].staleness = {10.0, 20.0, 30.0};
  runs[1].staleness = {30.0, std::nullopt};
  runs[2].staleness = {20.0, 40.0};
  EXPECT_THAT(medians_by_time(runs, &StoredRun::staleness), ElementsAre(20.0, 20.0, 30.0));
  EXPECT_THAT(medians_by_time(runs, &StoredRun::detector_periods), ElementsAre());
}

}  // namespace
}  // namespace ctn::navigation::run
