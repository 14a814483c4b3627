#include "results.h"

#include <gtest/gtest.h>

#include <string>

#include "sample.h"

namespace ctn::demo {
namespace {

const char* const kPrinted =
    R"({"scheduler": "catan", "cpus": [1], "response_time_ms": {"mean": 170.5, "p50": 170, "p95": 190},
  "predicted_response_time_ms": 175.0, "source_hz": 11.3, "angle_deg_mean": 3.5, "lost_fraction": 0.0,
  "compute_ms": {"camera": 25, "detect": 58, "plan": 1}, "real_time": true})";

TEST(ParseMeasured, TakesWhatTheProgramPrints) {
  const auto run = parse_measured({1, {1}, "catan", 1.0, 1, 3.0}, kPrinted);
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run->response_ms, 170.5);
  EXPECT_EQ(run->predicted_ms, 175.0);
  EXPECT_EQ(run->compute.detect, 58.0);
}

TEST(ParseMeasured, TellsWhatIsMissing) {
  for (const char* text : {"", "{}", "[1]", R"({"response_time_ms": 3})"}) {
    EXPECT_FALSE(parse_measured({}, text).ok()) << text;
  }
}

TEST(ParseMeasured, NothingMeasuredIsZero) {
  std::string text = kPrinted;
  text.replace(text.find("170.5"), 5, "null");
  const auto run = parse_measured({}, text);
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run->response_ms, 0.0);
}

TEST(Results, SurviveTheFile) {
  Results results = sample_results();
  results.no_real_time = "refused";
  const auto again = parse_results(to_json(results));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(to_json(*again), to_json(results));
  EXPECT_EQ(again->runs.size(), results.runs.size());
  EXPECT_EQ(again->host, results.host);
}

TEST(Results, AreNotReadFromAnotherFile) {
  EXPECT_FALSE(parse_results("{}").ok());
  EXPECT_FALSE(parse_results(R"({"made_by": "catan_demo", "version": 2})").ok());
}

}  // namespace
}  // namespace ctn::demo
