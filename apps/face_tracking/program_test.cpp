// The program as a script sees it: what it prints where, and how it ends.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include <nlohmann/json.hpp>

#include "program/testing/report_of.h"
#include "program/testing/run_command.h"

namespace ctn::face_tracking {
namespace {

using program::testing::Ended;
using program::testing::run_command;

Ended run(const std::string& before, const std::string& arguments) {
  return run_command(before + " '" FACE_TRACKING_PROGRAM "' " + arguments);
}

TEST(Program, PrintsOneJsonDocumentAndNothingElse) {
  for (const char* scheduler : {"default", "catan", "rate:8Hz"}) {
    const Ended ended = run("", std::string("--json --seconds 2 --scheduler ") + scheduler);
    ASSERT_EQ(ended.code, 0) << scheduler;
    const auto json = nlohmann::json::parse(ended.out, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << ended.out;
    EXPECT_EQ(json["scheduler"], scheduler);
    EXPECT_GT(json["source_hz"].get<double>(), 0.0);
    EXPECT_EQ(json["predicted_response_time_ms"].is_number(), std::string(scheduler) == "catan");
  }
}

TEST(Program, EndsCleanlyOnASignalAndPrintsWhatItHas) {
  const Ended ended = run("timeout --preserve-status -s TERM 6", "--json --seconds 600");
  EXPECT_EQ(ended.code, 128 + 15);
  const auto json = nlohmann::json::parse(ended.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << ended.out;
  EXPECT_EQ(json["interrupted"], true);
}

TEST(Program, LeavesWithTwoOnAMistake) {
  for (const char* arguments : {"--scheduler fastest", "--scheduler rate:0", "--cpus 4095", "--app /nowhere/app.yaml",
                                "--speed nan", "--no-such-option", "--cores 2", "--costs x", "--virtual --cpus 0",
                                "--virtual --costs /nowhere", "--virtual --scheduler fastest"}) {
    const Ended ended = run("", arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_EQ(ended.out, "") << arguments;
  }
}

TEST(Program, LeavesWithOneWhereTheRecordCannotBeMade) {
  EXPECT_EQ(run("", "--seconds 1 --record /nowhere/record.db").code, 1);
}

TEST(Program, InVirtualTimeItIsRecorded) {
  const std::string path = testing::TempDir() + "virtual_" + std::to_string(getpid()) + ".catan";
  std::remove(path.c_str());
  ASSERT_EQ(run("", "--virtual --seconds 1 --slowdown 3 --record " + path).code, 0);
  const auto report = program::testing::report_of(path);
  ASSERT_FALSE(report.is_discarded());
  EXPECT_EQ(report["scheduler"], "catan");
  EXPECT_NE(report["note"].get<std::string>().find("virtual"), std::string::npos);
}

TEST(Program, InVirtualTimePrintsTheSameBytesEachTime) {
  const std::string options = "--virtual --seconds 1 --cores 2 --slowdown 3 --json --seed ";
  const Ended first = run("", options + "7");
  ASSERT_EQ(first.code, 0);
  EXPECT_EQ(first.out, run("", options + "7").out);
  const auto json = nlohmann::json::parse(first.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << first.out;
  EXPECT_EQ(json["virtual"], true);
  EXPECT_EQ(json["cores"], 2);
  EXPECT_EQ(json["seconds"], 1.0);
  EXPECT_GE(json["pictures_found"].get<int>(), 3) << "the detections are real";
  EXPECT_NE(first.out, run("", options + "8").out);
}

// Nothing that the functions do changes what runs cost, so the app's own code in virtual time and the app without any
// code respond alike.
TEST(Program, InVirtualTimeRespondsAsTheSimulatorSays) {
  for (const std::string scheduler : {"default", "catan"}) {
    const std::string arguments = " --seconds 1 --seed 3 --cores 1 --json --scheduler " + scheduler;
    const Ended app = run("", "--virtual" + arguments);
    const Ended sim = run_command("'" CATAN_COMMAND "' sim '" FACE_TRACKING_FOLDER
                                  "/face_tracking.yaml' --costs '" FACE_TRACKING_FOLDER "/face_tracking.costs.yaml'" +
                                  arguments);
    ASSERT_EQ(app.code, 0);
    ASSERT_EQ(sim.code, 0);
    const auto ours = nlohmann::json::parse(app.out)["response_time_ms"];
    const auto theirs = nlohmann::json::parse(sim.out)["runs"][0]["chains"][0]["response_ms"];
    for (const char* figure : {"mean", "p50", "p95"}) {
      EXPECT_DOUBLE_EQ(ours[figure].get<double>(), theirs[figure].get<double>()) << scheduler << ' ' << figure;
    }
  }
}

TEST(Program, SlowdownActsOnVirtualCosts) {
  const auto response = [](const std::string& slowdown) {
    const Ended ended = run("", "--virtual --seconds 2 --json --slowdown " + slowdown);
    return nlohmann::json::parse(ended.out)["response_time_ms"]["mean"].get<double>();
  };
  EXPECT_NEAR(response("6") / response("2"), 3.0, 0.01);
}

}  // namespace
}  // namespace ctn::face_tracking
