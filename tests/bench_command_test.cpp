// catan bench from outside: that it measures everything that it may, in good time, and what its document looks like.
// What the figures are is the machine's affair.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include <nlohmann/json.hpp>

#include "command_test.h"
#include "os/testing/requires_real_time.h"

namespace ctn::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Outcome bench(const std::string& arguments) { return run_catan("bench " + arguments, CATAN_TESTS); }

void expect_summary(const json& summary) {
  for (const char* key : {"count", "mean", "p50", "p99", "max"}) EXPECT_TRUE(summary[key].is_number()) << summary;
  EXPECT_GT(summary["count"], 0);
  EXPECT_LE(summary["p50"], summary["p99"]);
  EXPECT_LE(summary["p99"], summary["max"]);
}

void expect_figure(const json& figure) {
  SCOPED_TRACE(figure.dump());
  EXPECT_TRUE(figure["figure"].is_string());
  EXPECT_TRUE(figure["where"].is_string());
  EXPECT_TRUE(figure["unit"] == "us" || figure["unit"] == "%");
  expect_summary(figure["measured"]);
  EXPECT_EQ(figure["baseline"].is_null(), figure["baseline_is"] == "");
  EXPECT_EQ(figure["baseline"].is_null(), figure["ratio"].is_null());
  if (!figure["baseline"].is_null()) expect_summary(figure["baseline"]);
  for (const char* limit : {"ratio", "p50", "p99"}) EXPECT_TRUE(figure["goal"].contains(limit));
  EXPECT_TRUE(figure["met"].is_boolean() || figure["met"].is_null());
}

TEST(Bench, MeasuresWhatItMayAndTellsPrograms) {
  const Outcome outcome = bench("--quick --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  const json document = json::parse(outcome.out);
  EXPECT_TRUE(document["core"].is_number());
  EXPECT_TRUE(document["other_core"].is_number() || document["other_core"].is_null());
  EXPECT_FALSE(document["host"]["kernel"].get<std::string>().empty());

  std::set<std::string> measured;
  for (const json& figure : document["figures"]) {
    expect_figure(figure);
    measured.insert(figure["figure"]);
  }
  EXPECT_TRUE(measured.contains("report of a run")) << "needs no permission";
  for (const json& skipped : document["skipped"]) {
    EXPECT_THAT(outcome.err, HasSubstr(skipped["figure"].get<std::string>()));
    EXPECT_FALSE(skipped["why"].get<std::string>().empty());
  }
  CATAN_REQUIRE(document["skipped"].empty(), "needs what these figures need: " << document["skipped"]);
  for (const char* name : {"hand-over", "trigger to first instruction", "CPU of scheduling", "housekeeper", "server"}) {
    EXPECT_TRUE(measured.contains(name)) << name;
  }
  EXPECT_TRUE(measured.contains("dispatchers") || measured.contains("triggers")) << "frames, or fixed priorities";
}

TEST(Bench, RefusesMistakes) {
  for (const std::string arguments : {"--cpus x", "--cpus 130000", "--seconds 0", "--seconds x", "extra"}) {
    const Outcome outcome = bench(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
  EXPECT_THAT(bench("--help").out, HasSubstr("Examples:"));
}

}  // namespace
}  // namespace ctn::test
