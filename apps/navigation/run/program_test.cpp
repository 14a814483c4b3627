// The program as a script sees it: what it prints where, and how it ends.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>
#include <opencv2/videoio.hpp>

#include "program/testing/report_of.h"
#include "program/testing/run_command.h"

namespace ctn::navigation::run {
namespace {

using program::testing::Ended;
using program::testing::run_command;

Ended run(const std::string& arguments, const std::string& before = "") {
  return run_command(before + " '" NAVIGATION_PROGRAM "' " + arguments);
}

std::string temporary(const std::string& name) {
  return ::testing::TempDir() + "navigation_program_" + std::to_string(getpid()) + "_" + name;
}

TEST(Program, InVirtualTimePrintsTheSameBytesEachTime) {
  for (const std::string scheduler : {"catan", "default"}) {
    const std::string options = "--virtual --seconds 3 --json --scheduler " + scheduler + " --seed ";
    const Ended first = run(options + "7");
    ASSERT_EQ(first.code, 0);
    EXPECT_EQ(first.out, run(options + "7").out);
    const auto json = nlohmann::json::parse(first.out, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << first.out;
    EXPECT_EQ(json["virtual"], true);
    EXPECT_EQ(json["scheduler"], scheduler);
    EXPECT_EQ(json["figures"]["seconds"], 3.0);
    EXPECT_EQ(json["chains"][0]["predicted_response_ms"].is_number(), scheduler == "catan");
    EXPECT_NE(first.out, run(options + "8").out);
  }
}

TEST(Program, InVirtualTimeItIsRecorded) {
  const std::string path = temporary("record.catan");
  std::remove(path.c_str());
  ASSERT_EQ(run("--virtual --seconds 3 --record " + path).code, 0);
  const auto report = program::testing::report_of(path);
  ASSERT_FALSE(report.is_discarded());
  EXPECT_EQ(report["scheduler"], "catan");
  EXPECT_NE(report["note"].get<std::string>().find("virtual"), std::string::npos);
}

TEST(Program, InVirtualTimeABatchGoesOnAndDrawsNothing) {
  const std::string folder = temporary("batch");
  std::filesystem::remove_all(folder);
  const std::string options = "--virtual --seconds 2 --json --scheduler default --runs 2 --out " + folder;
  const Ended first = run(options);
  ASSERT_EQ(first.code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder + "/run-1.json"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/run-2.json"));
  EXPECT_EQ(run(options).out, first.out);
  EXPECT_EQ(run("--virtual --seconds 2 --runs 2 --out " + folder).code, 2) << "another scheduler";
  std::filesystem::remove_all(folder);
}

// Others ask the program which runs belong together, so it says the same before a run and in its document.
TEST(Program, InVirtualTimeItTellsWhatABatchHasInCommon) {
  const std::string options = "--virtual --seconds 1 --scheduler default ";
  const auto document = nlohmann::json::parse(run(options + "--seed 7 --json").out, nullptr, false);
  const auto told = nlohmann::json::parse(run(options + "--in-common").out, nullptr, false);
  ASSERT_TRUE(told.is_object() && document.is_object());
  EXPECT_EQ(document["in_common"].size(), told.size());
  for (const auto& name : document["in_common"]) {
    EXPECT_EQ(document[name.get<std::string>()], told[name.get<std::string>()]) << name;
  }
  EXPECT_TRUE(told.contains("inputs"));
  EXPECT_FALSE(told.contains("seed"));
}

TEST(Program, InVirtualTimeItDrawsAPictureASecond) {
  const std::string folder = temporary("pictures");
  std::filesystem::remove_all(folder);
  ASSERT_EQ(run("--virtual --seconds 2 --scheduler default --pictures " + folder).code, 0);
  EXPECT_GT(std::filesystem::file_size(folder + "/second-0001.png"), 5000U);
  EXPECT_GT(std::filesystem::file_size(folder + "/second-0002.png"), 5000U);
  std::filesystem::remove_all(folder);
}

TEST(Program, InVirtualTimeAReplayChangesNothing) {
  const std::string page = temporary("replay.html");
  const std::string options = "--virtual --seconds 3 --json --seed 7";
  const Ended with = run(options + " --replay " + page);
  ASSERT_EQ(with.code, 0);
  EXPECT_EQ(with.out, run(options).out);
  EXPECT_GT(std::filesystem::file_size(page), 20000U);
  std::filesystem::remove(page);
  EXPECT_EQ(run("--virtual --seconds 1 --replay /nowhere/page.html").code, 1);
}

TEST(Program, LeavesWithTwoOnAMistake) {
  for (const char* arguments :
       {"--virtual --scheduler fastest", "--scheduler rate:0", "--cpus 4095", "--app /nowhere/app.yaml",
        "--virtual --app /nowhere/app.yaml", "--no-such-option", "--cores 2", "--detector yolo", "--virtual --cpus 0",
        "--virtual --detector yolo --model /nowhere/a.cfg /nowhere/a.weights",
        "--virtual --detector hog --film /nowhere"}) {
    const Ended ended = run(arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_EQ(ended.out, "") << arguments;
  }
}

TEST(Program, LeavesWithOneWhereSomethingCannotBeReadOrMade) {
  EXPECT_EQ(run("--virtual --seconds 1 --record /nowhere/record.db").code, 1);
  EXPECT_EQ(run("--virtual --map /nowhere/world.yaml").code, 1);
  EXPECT_EQ(run("--virtual --seconds 1 --pictures /proc/nowhere").code, 1);
}

TEST(Program, InLifeTheDetectorLooks) {
  const std::string film = temporary("film.avi");
  cv::VideoWriter writer(film, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10.0, {320, 240});
  for (int frame = 0; frame < 3; ++frame) writer.write(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(40 * frame)));
  writer.release();
  const Ended ended = run("--json --seconds 6 --scheduler default --detector hog --film " + film);
  std::remove(film.c_str());
  ASSERT_EQ(ended.code, 0);
  const auto json = nlohmann::json::parse(ended.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << ended.out;
  EXPECT_GT(json["figures"]["detector_outputs"].get<double>(), 1.0);
  EXPECT_EQ(json["detector_period_ms_by_10s"].size(), 1U);
  EXPECT_EQ(json["detector"], "hog");
}

// By default GM runs for the first time after five seconds, and the robot stands until then.
#ifdef CATAN_SANITIZED
constexpr const char* kUntilItDrives = "12";
constexpr const char* kUntilItDrivesUnderCatan = "12";
#else
constexpr const char* kUntilItDrives = "9";
constexpr const char* kUntilItDrivesUnderCatan = "6";
#endif

TEST(Program, InLifeItDrives) {
  for (const std::string scheduler : {"default", "catan"}) {
    const std::string seconds = scheduler == "catan" ? kUntilItDrivesUnderCatan : kUntilItDrives;
    const Ended ended = run("--json --seconds " + seconds + " --scheduler " + scheduler);
    ASSERT_EQ(ended.code, 0) << scheduler;
    const auto json = nlohmann::json::parse(ended.out, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << ended.out;
    EXPECT_GT(json["figures"]["way_m"].get<double>(), 0.0) << scheduler;
    EXPECT_GT(json["world_thread"]["cpu_share"].get<double>(), 0.0);
    EXPECT_FALSE(json.contains("cores"));
    EXPECT_GT(json["nodes"]["LM"]["cost_ratio"].get<double>(), 0.0) << scheduler;
  }
}

}  // namespace
}  // namespace ctn::navigation::run
