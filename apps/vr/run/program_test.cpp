// The program as a script sees it: what it prints where, and how it ends.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "program/testing/run_command.h"

namespace ctn::vr::run {
namespace {

using program::testing::Ended;
using program::testing::run_command;

Ended run(const std::string& arguments, const std::string& before = "") {
  return run_command(before + " '" VR_PROGRAM "' " + arguments);
}

// What runs cost beside what they are charged, in ms (sim/machine.h): about.
constexpr double kScheduling = 0.015;

std::string temporary(const std::string& name) {
  return ::testing::TempDir() + "vr_program_" + std::to_string(getpid()) + "_" + name;
}

// Nothing can be drawn here: then the program says what to install, and cannot run.
bool cannot_draw(const Ended& ended) {
  return ended.code == 1 && run("--virtual --seconds 1 2>&1").out.find("apt-get install") != std::string::npos;
}

TEST(Program, InVirtualTimePrintsTheSameBytesEachTime) {
  const std::string record = temporary("record.catan");
  const std::string options = "--virtual --seconds 3 --json --scheduler fifo --seed 7";
  const Ended first = run(options + " --record " + record);
  if (cannot_draw(first)) GTEST_SKIP() << "EGL is not installed";
  ASSERT_EQ(first.code, 0);
  EXPECT_EQ(first.out, run(options).out);
  EXPECT_GT(std::filesystem::file_size(record), 10000U);
  std::filesystem::remove(record);
  const auto json = nlohmann::json::parse(first.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << first.out;
  EXPECT_EQ(json["virtual"], true);
  EXPECT_EQ(json["scheduler"], "fifo");
  EXPECT_GT(json["figures"]["ticks"].get<double>(), 100.0);
  EXPECT_GT(json["figures"]["response_ms A_mean"].get<double>(), 8.0);
}

TEST(Program, InVirtualTimeABatchGoesOn) {
  const std::string folder = temporary("batch");
  const std::string options = "--virtual --seconds 1 --json --scheduler default --out " + folder + " --runs ";
  const Ended first = run(options + "1");
  if (cannot_draw(first)) GTEST_SKIP() << "EGL is not installed";
  ASSERT_EQ(first.code, 0);
  const Ended both = run(options + "2");
  ASSERT_EQ(both.code, 0);
  const auto json = nlohmann::json::parse(both.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << both.out;
  EXPECT_EQ(json["runs"].size(), 2U);
  EXPECT_EQ(json["summary"]["ticks"]["count"], 2);
  EXPECT_EQ(run(options + "2 --hz 90").code, 2) << "other options";
  std::filesystem::remove_all(folder);
}

TEST(Program, LeavesWithTwoOnAMistake) {
  for (const char* arguments :
       {"--virtual --scheduler fastest", "--app /nowhere/app.yaml --virtual", "--no-such-option", "--cores 2",
        "--virtual --size 1x1", "--virtual --dataset /nowhere", "--virtual --calibration /nowhere"}) {
    const Ended ended = run(arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_EQ(ended.out, "") << arguments;
  }
}

TEST(Program, InLifeItShowsAndInVirtualTimeRunsThenCostAsMuch) {
  const std::string options = "--json --seconds 3 --scheduler default --size 160x120 --camera 10 ";
  const Ended ended = run(options);
  if (cannot_draw(ended)) GTEST_SKIP() << "EGL is not installed";
  ASSERT_EQ(ended.code, 0);
  const auto json = nlohmann::json::parse(ended.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << ended.out;
  EXPECT_GT(json["figures"]["ticks"].get<double>(), 60.0);
  EXPECT_GT(json["display_thread"]["cpu_share"].get<double>(), 0.0);

  const std::string file = temporary("life.json");
  std::ofstream(file) << ended.out;
  const auto simulated = [&options](const std::string& more) {
    return nlohmann::json::parse(run(options + "--virtual " + more).out, nullptr, false);
  };
  const auto plain = simulated("");
  const auto calibrated = simulated("--calibration " + file);
  ASSERT_FALSE(plain.is_discarded() || calibrated.is_discarded());
  for (const char* node : {"Render", "Timewarp"}) {
    const auto compute = [node](const nlohmann::json& outcome) {
      return outcome["nodes"][node]["compute_ms"]["mean"].get<double>();
    };
    const double ratio = json["nodes"][node]["cost_ratio"].get<double>();
    const double charged = compute(plain) - kScheduling;
    EXPECT_NEAR(compute(calibrated), ratio * charged + kScheduling, 0.01 * ratio * charged + 0.01) << node;
  }
  std::filesystem::remove(file);
}

// The chain of a camera with a clock begins with the exposure and ends with a tick of the display. Here one period is
// twelve of the other, so that all its latencies are whole periods of the display apart, however long runs take. Those
// from Camera's runs are not.
TEST(Program, InLifeTheCamerasChainBeginsWithTheExposure) {
  const Ended ended = run("--json --seconds 4 --scheduler default --size 160x120 --camera 10 --seed 4");
  if (cannot_draw(ended)) GTEST_SKIP() << "EGL is not installed";
  ASSERT_EQ(ended.code, 0);
  const auto json = nlohmann::json::parse(ended.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << ended.out;
  const auto& chain = json["chains"][2];
  ASSERT_EQ(chain["path"][0], "exposure");
  const auto& latency = chain["latency_ms"];
  ASSERT_GT(latency["count"], 0);
  constexpr double kTick = 1e3 / 120.0;
  const double apart = latency["p95"].get<double>() - latency["p50"].get<double>();
  EXPECT_NEAR(std::remainder(apart, kTick), 0.0, 0.02) << chain;
  const double mean_apart =
      latency["count"].get<double>() * (latency["mean"].get<double>() - latency["p50"].get<double>());
  EXPECT_NEAR(std::remainder(mean_apart, kTick), 0.0, 0.05) << chain;
}

}  // namespace
}  // namespace ctn::vr::run
