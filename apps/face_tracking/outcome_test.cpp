#include "outcome.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace ctn::face_tracking {
namespace {

Outcome sample() {
  Outcome outcome;
  outcome.options.cpus = {0, 1};
  outcome.seconds = 5.0;
  outcome.snapshot.source_hz = 11.5;
  outcome.snapshot.real_time = true;
  outcome.snapshot.chains.push_back(
      {{"camera", "detect", "plan", "motor"}, {40, 170, 168, 190, 200, 210}, {}, {}, 175.0});
  outcome.snapshot.nodes.push_back({"camera", {40, 25, 25, 26, 27, 28}, 11.4});
  outcome.tracking = {2500, 0.1, 0.02};
  return outcome;
}

TEST(Outcome, JsonHasWhatScriptsRead) {
  const auto json = nlohmann::json::parse(to_json(sample()));
  EXPECT_EQ(json["scheduler"], "catan");
  EXPECT_EQ(json["cpus"], (std::vector<int>{0, 1}));
  EXPECT_EQ(json["response_time_ms"]["mean"], 170.0);
  EXPECT_EQ(json["response_time_ms"]["p50"], 168.0);
  EXPECT_EQ(json["response_time_ms"]["p95"], 190.0);
  EXPECT_EQ(json["predicted_response_time_ms"], 175.0);
  EXPECT_EQ(json["source_hz"], 11.5);
  EXPECT_NEAR(json["angle_deg_mean"].get<double>(), 5.7296, 1e-3);
  EXPECT_EQ(json["lost_fraction"], 0.02);
  EXPECT_EQ(json["compute_ms"]["camera"], 25.0);
  EXPECT_EQ(json["real_time"], true);
}

TEST(Outcome, WithoutAPlanThePredictionIsNull) {
  Outcome outcome = sample();
  outcome.snapshot.chains.front().predicted_response_ms.reset();
  EXPECT_TRUE(nlohmann::json::parse(to_json(outcome))["predicted_response_time_ms"].is_null());
}

TEST(Outcome, NothingMeasuredIsNullNotZero) {
  const auto json = nlohmann::json::parse(to_json(Outcome{}));
  EXPECT_TRUE(json["response_time_ms"]["mean"].is_null());
}

TEST(Outcome, TextNamesTheSlowdown) {
  Outcome outcome = sample();
  outcome.options.slowdown = 2.5;
  EXPECT_NE(to_text(outcome).find("slowdown 2.5"), std::string::npos);
}

TEST(Outcome, SaysWhereItIsOfVirtualTime) {
  Outcome outcome = sample();
  EXPECT_FALSE(nlohmann::json::parse(to_json(outcome)).contains("virtual"));
  EXPECT_EQ(to_text(outcome).find("virtual"), std::string::npos);
  outcome.options.virtual_time = true;
  EXPECT_EQ(nlohmann::json::parse(to_json(outcome))["virtual"], true);
  EXPECT_NE(to_text(outcome).find("in virtual time on 1 core\n"), std::string::npos);
}

}  // namespace
}  // namespace ctn::face_tracking
