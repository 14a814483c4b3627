// catan report from outside, on the record of a real run (a seed of the record's fuzzer).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "command_test.h"

namespace ctn::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

Outcome report(const std::string& arguments) { return run_catan("report " + arguments, CATAN_RECORDS); }

TEST(ReportCommand, ShowsPredictedBesideMeasured) {
  const Outcome outcome = report("face_tracking");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* part : {"camera -> detect -> plan -> motor", "predicted", "response time", "Triggers"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
}

TEST(ReportCommand, PrintsOneJsonDocument) {
  const Outcome outcome = report("face_tracking --json --all");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto document = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(document["warm_up_included"], true);
  EXPECT_EQ(document["chains"][0]["latency_ms"]["count"], 12);
}

TEST(ReportCommand, PrintsAPage) {
  const Outcome outcome = report("face_tracking --html");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, StartsWith("<!DOCTYPE html>"));
  EXPECT_EQ(report("--html face_tracking").out, outcome.out);
}

// A folder that goes with all that is in it.
class ReportPages : public testing::Test {
 protected:
  ReportPages() {
    std::string pattern = (std::filesystem::temp_directory_path() / "catan-pages-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~ReportPages() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return folder_ + "/" + name; }

 private:
  std::string folder_;
};

TEST_F(ReportPages, AreWrittenToAFile) {
  const Outcome outcome = report("face_tracking --html " + file("page.html"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(read_all(file("page.html")), AllOf(StartsWith("<!DOCTYPE html>"), HasSubstr("catan-data")));
  EXPECT_EQ(report("face_tracking --html " + file("no/page.html")).exit_code, 1);
}

TEST_F(ReportPages, StayWhatTheyWereWhereAnotherIsInterrupted) {
  std::ofstream(file("page.html")) << "before";
  const std::string command = "ulimit -f 1; exec " CATAN_COMMAND " report " CATAN_RECORDS "/face_tracking --html " +
                              file("page.html") + " >/dev/null 2>&1";
  EXPECT_NE(std::system(command.c_str()), 0);
  EXPECT_EQ(read_all(file("page.html")), "before");
}

TEST_F(ReportPages, PutTwoRunsSideBySide) {
  const Outcome outcome = report("face_tracking --compare face_tracking --html " + file("page.html"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(read_all(file("page.html")), AllOf(HasSubstr("face_tracking (other)"), HasSubstr("side by side")));
}

TEST_F(ReportPages, RefuseWhatCannotBeCompared) {
  const std::string apps = std::string(CATAN_TESTS) + "/apps/";
  const Outcome simulated = run_catan("sim " + apps + "navigation.yaml --costs " + apps +
                                          "navigation.costs.yaml --cores 1 --seconds 1 --record " + file("other.catan"),
                                      CATAN_RECORDS);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const Outcome outcome = report("face_tracking --html --compare " + file("other.catan"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("no node in common"));
  const Outcome over = report("face_tracking --html " + file("other.catan"));
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_THAT(over.err, HasSubstr("is a record"));
}

TEST(ReportCommand, SaysWhyResponsesWereLate) {
  const Outcome outcome = report("face_tracking --all --why motor --worst 2");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* part : {"camera -> detect -> plan -> motor: 11 responses", "running", "#"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  const Outcome in_json = report("face_tracking --all --json --worst 2 --why 'camera>detect -> plan > motor'");
  EXPECT_EQ(in_json.exit_code, 0) << in_json.err;
  const auto document = nlohmann::json::parse(in_json.out);
  EXPECT_EQ(document["responses"], 11);
  EXPECT_EQ(document["worst"].size(), 2U);
  const Outcome none = report("face_tracking --why detect");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("0 (camera -> detect -> plan -> motor)"));
}

TEST(ReportCommand, MistakesExitWith2) {
  for (const char* arguments : {"", "nowhere", ".", "face_tracking --json --html", "face_tracking extra", "--html",
                                "face_tracking --compare face_tracking", "face_tracking --worst 2",
                                "face_tracking --why 0 --html", "face_tracking --why 0 --worst -1"}) {
    const Outcome outcome = report(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
  }
}

}  // namespace
}  // namespace ctn::test
