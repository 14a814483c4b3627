#include "program/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "program/slowed.h"

namespace ctn::program {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

class CalibrationFiles : public ::testing::Test {
 protected:
  CalibrationFiles() { std::filesystem::create_directories(folder_); }
  ~CalibrationFiles() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name) << text;
    return folder_ + "/" + name;
  }

  const std::string folder_ = ::testing::TempDir() + "calibration_" + std::to_string(getpid());
};

TEST_F(CalibrationFiles, AnOutcomeIsForAllRuns) {
  const std::string file = write("life.json", R"({"nodes": {"LM": {"rate_hz": 50.0, "cost_ratio": 1.5},
    "LP": {"cost_ratio": 0.25}, "laser": {"rate_hz": 50.0}, "odd": {"cost_ratio": -1.0}, "none": null}})");
  const auto calibration = Calibration::read(file, 3, 2);
  ASSERT_TRUE(calibration.ok());
  EXPECT_FALSE(calibration->by_seed());
  EXPECT_THAT(calibration->of(3), ElementsAre(Pair("LM", 1.5), Pair("LP", 0.25)));
  EXPECT_EQ(calibration->of(3), calibration->of(77));
  EXPECT_EQ(ratio_of(calibration->of(3), "LM"), 1.5);
  EXPECT_EQ(ratio_of(calibration->of(3), "laser"), 1.0);
}

TEST_F(CalibrationFiles, OfAFolderEachRunHasThatOfItsSeed) {
  write("run-3.json", R"({"nodes": {"LM": {"cost_ratio": 1.5}}})");
  write("run-4.json", R"({"nodes": {"LM": {"cost_ratio": 2.5}}})");
  const auto calibration = Calibration::read(folder_, 3, 2);
  ASSERT_TRUE(calibration.ok());
  EXPECT_TRUE(calibration->by_seed());
  EXPECT_THAT(calibration->of(3), ElementsAre(Pair("LM", 1.5)));
  EXPECT_THAT(calibration->of(4), ElementsAre(Pair("LM", 2.5)));

  const auto more = Calibration::read(folder_, 3, 3);
  ASSERT_FALSE(more.ok());
  EXPECT_EQ(more.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(more.error().message(), HasSubstr("run-5.json"));
}

TEST_F(CalibrationFiles, WhatSaysNothingIsRefused) {
  EXPECT_FALSE(Calibration::read(folder_ + "/none.json", 1, 1).ok());
  for (const char* text : {"", "[]", "{}", R"({"nodes": []})", R"({"nodes": {"LM": {"cost_ratio": "1.5"}}})"}) {
    const auto calibration = Calibration::read(write("odd.json", text), 1, 1);
    ASSERT_FALSE(calibration.ok()) << text;
    EXPECT_THAT(calibration.error().message(), HasSubstr("cost_ratio")) << text;
  }
}

// A function that burns twice what it is charged, on a board on which all takes four times as long.
TEST(CostMeter, ComparesWhatRunsUseWithWhatTheyAreCharged) {
  CostMeter meter(4.0, 0ns);
  std::chrono::nanoseconds used{0};
  const auto node = meter.metered("LM", [&used](ctn::Run& run) {
    const std::chrono::nanoseconds begin = thread_cpu_time();
    while (thread_cpu_time() - begin < 8ms) {
    }
    run.charge(1ms);
    used += thread_cpu_time() - begin;
  });
  const auto idle = meter.metered("laser", [](ctn::Run&) {});
  for (int i = 0; i < 3; ++i) {
    ctn::Run run;
    node(run);
    ctn::Run other;
    idle(other);
  }
  const CostRatios ratios = meter.ratios();
  ASSERT_THAT(ratios, ElementsAre(Pair("LM", ::testing::Ge(2.0))));
  // What the meter itself takes is in it, and nothing else is.
  EXPECT_NEAR(ratios.at("LM"), std::chrono::duration<double>(used) / 3ms / 4.0, 0.02);
}

TEST(CostMeter, LeavesOutWhatANodeDoesForTheFirstTime) {
  CostMeter meter(1.0, std::chrono::hours(1));
  const auto node = meter.metered("LM", [](ctn::Run& run) { run.charge(1ms); });
  ctn::Run run;
  node(run);
  node(run);
  EXPECT_TRUE(meter.ratios().empty());
}

}  // namespace
}  // namespace ctn::program
