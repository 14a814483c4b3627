// The program as a script sees it: the smallest study, run, gone on with, drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "program/testing/run_command.h"

namespace ctn::case_studies {
namespace {

using program::testing::Ended;
using program::testing::run_command;
using ::testing::HasSubstr;
using ::testing::Not;

Ended run_program(const std::string& arguments) { return run_command("'" CASE_STUDIES_PROGRAM "' " + arguments); }

std::string contents_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(CaseStudiesProgram, RunsGoesOnAndDraws) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("case_studies_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  const std::string options = "--only map1 --seconds 2 --runs 2 --no-life --out " + folder.string();
  const Ended first = run_program(options);
  ASSERT_EQ(first.code, 0) << contents_of(folder / "programs.log");
  EXPECT_THAT(first.out, HasSubstr("6 of 6 runs"));
  const std::string page = contents_of(folder / "report.html");
  EXPECT_THAT(page, HasSubstr("Collisions on map 1"));
  EXPECT_THAT(page, Not(HasSubstr("Not all runs")));
  EXPECT_THAT(page, Not(HasSubstr("Crowds")));
  // What is there is not run again, and comes to the same.
  EXPECT_EQ(run_program(options).out, first.out);
  EXPECT_THAT(contents_of(folder / "programs.log"), HasSubstr("(from "));
  EXPECT_EQ(run_program(options + " --page").out, first.out);
  // Runs of 2 s are not shown as runs of 3 s, nor beside them.
  const Ended longer = run_program("--only map1 --seconds 3 --runs 2 --no-life --page --out " + folder.string());
  EXPECT_EQ(longer.code, 1);
  EXPECT_THAT(longer.out, HasSubstr("0 of 6 runs"));
  EXPECT_THAT(longer.out, HasSubstr("2 of 2 runs are left out: run-1001.json is of another seconds (2.0, not 3.0)"));
  std::filesystem::remove_all(folder);
}

TEST(CaseStudiesProgram, RunsTheHeadset) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("case_studies_vr_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  const Ended ended = run_program("--only headset-20hz --seconds 1 --runs 2 --out " + folder.string());
  ASSERT_EQ(ended.code, 0) << contents_of(folder / "programs.log");
  const std::string page = contents_of(folder / "report.html");
  std::filesystem::remove_all(folder);
  if (ended.out.find("left out") != std::string::npos) GTEST_SKIP() << "EGL is not installed";
  EXPECT_THAT(ended.out, HasSubstr("20 of 20 runs"));
  EXPECT_THAT(page, HasSubstr("Ticks missed"));
  EXPECT_THAT(page, Not(HasSubstr("The maps"))) << "no study is of the robot";
}

TEST(CaseStudiesProgram, SaysThatTheHeadsetIsLeftOut) {
  const std::string folder = ::testing::TempDir() + "/case_studies_without_vr_" + std::to_string(getpid());
  const std::string options = "--only headset --out " + folder + " --vr-program ";
  for (const char* program : {"/nowhere/vr", "/bin/false"}) {
    const Ended ended = run_program(options + program + " 2>&1");
    EXPECT_EQ(ended.code, 0) << program;
    EXPECT_THAT(ended.out, HasSubstr("the studies of the headset are left out")) << program;
    EXPECT_THAT(ended.out, HasSubstr("left out   A headset")) << program;
  }
  EXPECT_THAT(contents_of(folder + "/report.html"), HasSubstr("It cannot be run here"));
  std::filesystem::remove_all(folder);
}

TEST(CaseStudiesProgram, LeavesWithTwoOnAMistake) {
  for (const char* arguments : {"--only nothing", "--program /nowhere/navigation", "--runs 1", "--jobs 0", "stray"}) {
    EXPECT_EQ(run_program(std::string(arguments) + " --out " + ::testing::TempDir() + "/mistakes").code, 2)
        << arguments;
  }
}

}  // namespace
}  // namespace ctn::case_studies
