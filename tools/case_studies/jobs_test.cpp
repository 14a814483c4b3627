#include "jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <iterator>

#include "sample.h"

namespace ctn::case_studies {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

class JobsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) / ("jobs_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Plan plan() const {
    return {{{"navigation", {"/bin/navigation", folder_}}, {"vr", {"/opt/vr", folder_ / "of-vr"}}}, 11};
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string text_of(const std::string& name) const {
    std::ifstream stream(folder_ / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  Ran run(const std::vector<Job>& jobs, int at_a_time = 2) {
    return run_jobs(
        jobs, at_a_time, file("log"), [this] { return signal_.load(); },
        [this](const std::string& line) { lines_.push_back(line); });
  }

  std::filesystem::path folder_;
  std::atomic<int> signal_ = 0;
  std::vector<std::string> lines_;
};

TEST_F(JobsTest, BatchesTakeTurns) {
  const Jobs jobs = make_jobs({sample_study()}, plan());
  std::vector<std::string> names;
  for (const Job& job : jobs.runs) names.push_back(job.name);
  EXPECT_THAT(names, ElementsAre("sample/catan, runs 1 to 6 of 8", "sample/other, runs 1 to 6 of 8",
                                 "sample/catan, runs 7 to 8 of 8", "sample/other, runs 7 to 8 of 8"));
  EXPECT_EQ(jobs.runs[2].command,
            "exec '/bin/navigation' '--virtual' '--seed' '17' '--runs' '2' '--out' '" + file("sample/catan") + "'");
  EXPECT_THAT(jobs.runs[1].command, HasSubstr("'--costs' '" + jobs.measurements.at(0).writes + "'"));
  EXPECT_EQ(jobs.runs[3].seconds, 200.0);
}

TEST_F(JobsTest, WhatIsMeasuredIsNotMeasuredAgain) {
  const Jobs jobs = make_jobs({sample_study()}, plan());
  ASSERT_EQ(jobs.measurements.size(), 1U);
  EXPECT_THAT(jobs.measurements[0].command, HasSubstr("'--seed' '10'"));
  EXPECT_THAT(jobs.measurements[0].writes, StartsWith(file("sample/whole-run-")));
  std::filesystem::create_directories(folder_ / "sample");
  std::ofstream(jobs.measurements[0].writes) << "there";
  EXPECT_TRUE(make_jobs({sample_study()}, plan()).measurements.empty());
}

// A record once served whatever was asked for later: another detector, a longer run, a map that had changed.
TEST_F(JobsTest, WhatIsMeasuredOfSomethingElseIsMeasuredAnew) {
  Study study = sample_study();
  std::ofstream(folder_ / "map.yaml") << "a wall";
  study.measurements[0].arguments = {"--map", file("map.yaml"), "--seconds", "3"};
  const auto measured = [&](const Plan& of) { return make_jobs({study}, of).measurements; };
  const std::string record = measured(plan()).at(0).writes;
  std::filesystem::create_directories(folder_ / "sample");
  std::ofstream(record) << "there";
  ASSERT_TRUE(measured(plan()).empty());

  Plan other_seed = plan();
  other_seed.seed = 5000;
  ASSERT_THAT(measured(other_seed), SizeIs(1));
  EXPECT_NE(measured(other_seed)[0].writes, record);
  study.measurements[0].arguments[3] = "90";
  ASSERT_THAT(measured(plan()), SizeIs(1));
  EXPECT_THAT(make_jobs({study}, plan()).runs[1].command, HasSubstr("'--costs' '" + measured(plan())[0].writes + "'"));
  study.measurements[0].arguments[3] = "3";
  std::ofstream(folder_ / "map.yaml") << "another wall";
  EXPECT_THAT(measured(plan()), SizeIs(1));
}

// Maps 1 and 2 are files, too: beside the program. So is the image that a map names.
TEST_F(JobsTest, WhatIsMeasuredOfAnotherMap1IsMeasuredAnew) {
  Study study = sample_study();
  Plan here = plan();
  here.apps["navigation"].program = file("navigation");
  const auto record_on = [&](const std::string& map) {
    study.measurements[0].arguments = {"--map", map};
    return make_jobs({study}, here).measurements.at(0).writes;
  };
  std::ofstream(folder_ / "map1.yaml") << "a wall";
  const std::string before = record_on("1");
  EXPECT_EQ(record_on("1"), before);
  std::ofstream(folder_ / "map1.yaml") << "another wall";
  EXPECT_NE(record_on("1"), before);

  std::ofstream(folder_ / "mine.yaml") << "image: { file: room.pgm, metres_per_pixel: 0.5 }\n";
  std::ofstream(folder_ / "room.pgm") << "one";
  const std::string of_one = record_on(file("mine.yaml"));
  std::ofstream(folder_ / "room.pgm") << "another";
  EXPECT_NE(record_on(file("mine.yaml")), of_one);
}

TEST_F(JobsTest, EachAppHasItsProgramAndItsFolder) {
  Study study = sample_study();
  study.program = "vr";
  const Jobs jobs = make_jobs({sample_study(), study}, plan());
  EXPECT_THAT(jobs.runs[0].command, HasSubstr("'/bin/navigation'"));
  EXPECT_THAT(jobs.runs[2].command, HasSubstr("'/opt/vr'"));
  EXPECT_THAT(jobs.runs[2].command, HasSubstr("'--out' '" + file("of-vr/sample/catan") + "'"));
  EXPECT_THAT(jobs.measurements[1].writes, StartsWith(file("of-vr/sample/whole-run-")));
}

TEST_F(JobsTest, AStudyThatCannotBeRunHasNone) {
  Study study = sample_study();
  study.missing = "a second CPU";
  study.program = "nowhere";
  EXPECT_TRUE(make_jobs({study}, plan()).runs.empty());
  EXPECT_TRUE(make_jobs({study}, plan()).measurements.empty());
}

TEST_F(JobsTest, FailuresStopNothingElse) {
  const Ran ran = run({{"one", "echo complaint >&2; exit 3", 1.0}, {"two", "exec touch " + file("two"), 1.0}}, 1);
  EXPECT_EQ(ran.signal, 0);
  EXPECT_THAT(ran.failed, ElementsAre("one"));
  EXPECT_TRUE(std::filesystem::exists(file("two")));
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("one: FAILED"), Not(HasSubstr("FAILED"))));
  EXPECT_EQ(text_of("log"), "complaint\n");
}

TEST_F(JobsTest, AFileAppearsOnlyWhenItIsWhole) {
  const std::string half = "echo half >" + file("a/record") + ".unfinished; ";
  EXPECT_THAT(run({{"measure", half + "exit 1", 1.0, Stage::kVirtual, file("a/record")}}).failed,
              ElementsAre("measure"));
  EXPECT_FALSE(std::filesystem::exists(file("a/record")));
  EXPECT_TRUE(run({{"measure", half + "exit 0", 1.0, Stage::kVirtual, file("a/record")}}).failed.empty());
  EXPECT_EQ(text_of("a/record"), "half\n");
}

TEST_F(JobsTest, LiveOnesRunAloneAndWhatIsCalibratedByThemAfterwards) {
  const std::string log = "exec sh -c 'echo $0 >>" + file("order") + "' ";
  EXPECT_TRUE(run({{"calibrated", log + "calibrated", 1.0, Stage::kCalibrated},
                   {"live", log + "live", 1.0, Stage::kLive},
                   {"virtual", log + "virtual", 1.0}})
                  .failed.empty());
  EXPECT_EQ(text_of("order"), "virtual\nlive\ncalibrated\n");
}

TEST_F(JobsTest, ABatchIsCalibratedByWhatAnotherMeasuredInLife) {
  Study study = sample_study();
  study.batches[0].live = true;
  study.batches[1].calibration = study.batches[0].name;
  const Jobs jobs = make_jobs({study}, plan());
  EXPECT_EQ(jobs.runs[0].stage, Stage::kLive);
  EXPECT_THAT(jobs.runs[0].command, Not(HasSubstr("--calibration")));
  EXPECT_EQ(jobs.runs[1].stage, Stage::kCalibrated);
  EXPECT_THAT(jobs.runs[1].command, HasSubstr("'--calibration' '" + file("sample/catan") + "'"));
}

TEST_F(JobsTest, AProgramIsAskedWhatRunsHaveInCommon) {
  const Study study = sample_study();
  EXPECT_EQ(asking_what_is_in_common(study, study.batches[0], plan()), "'/bin/navigation' '--virtual' '--in-common'");
  EXPECT_THAT(asking_what_is_in_common(study, study.batches[1], plan()), HasSubstr("'--costs' '" + file("sample")));
}

TEST_F(JobsTest, ASignalEndsWhatRunsAndBeginsNothing) {
  signal_ = 15;
  const Ran ran = run({{"long", "exec sleep 600", 1.0}, {"never", "exec touch " + file("never"), 1.0}}, 1);
  EXPECT_EQ(ran.signal, 15);
  EXPECT_TRUE(ran.failed.empty()) << "it was ended, and did not fail";
  EXPECT_FALSE(std::filesystem::exists(file("never")));
}

}  // namespace
}  // namespace ctn::case_studies
