// catan report from outside, on the record of a real run (a seed of the record's fuzzer).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command_test.h"

namespace ctn::test {
namespace {

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
}

TEST(ReportCommand, MistakesExitWith2) {
  for (const char* arguments : {"", "nowhere", ".", "face_tracking --json --html", "face_tracking extra"}) {
    const Outcome outcome = report(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
  }
}

}  // namespace
}  // namespace ctn::test
