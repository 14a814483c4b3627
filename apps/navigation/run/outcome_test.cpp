#include "run/outcome.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <nlohmann/json.hpp>

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;

Outcome sample() {
  Outcome outcome;
  outcome.options.virtual_time = true;
  outcome.world = "two rooms";
  outcome.shortest_way = 15.0;  // 20 s at full speed
  outcome.findings.ending = Ending::kGoal;
  outcome.findings.lasted = 50s;
  outcome.findings.reached_at = 50s;
  outcome.findings.way = 17.5;
  outcome.findings.guidance_ages = {{1s, 100ms}, {2s, 300ms}, {49s, 50ms}};
  outcome.findings.scan_ages = {{1s, 10ms}, {2s, 30ms}};
  outcome.findings.appearances = {{10s, 0, 80ms}, {20s, 1, std::nullopt}, {30s, 0, 120ms}};
  outcome.snapshot.chains.push_back({{"scan", "LM"}, {40, 17.0, 16.0, 19.0, 20.0, 21.0}, {}, {}, 18.0});
  outcome.snapshot.chains.push_back({{"GL", "NC"}, {}, {}, {}, {}});
  outcome.snapshot.nodes.push_back({"LM", {40, 2.5, 2.5, 2.6, 2.7, 2.8}, 50.0});
  outcome.snapshot.objective = {{"scan -> LM", 1.0, {}}, {"period of LM", 0.5, {}}};
  return outcome;
}

TEST(Outcome, JsonHasWhatScriptsRead) {
  const auto json = nlohmann::json::parse(to_json(sample()));
  EXPECT_EQ(json["map"], "1");
  EXPECT_EQ(json["scheduler"], "catan");
  EXPECT_EQ(json["virtual"], true);
  EXPECT_EQ(json["cores"], 1);
  EXPECT_EQ(json["ended_by"], "goal");
  const auto& figures = json["figures"];
  EXPECT_EQ(figures["collided"], 0.0);
  EXPECT_EQ(figures["goal_s"], 50.0);
  EXPECT_EQ(figures["barn_score"], 20.0 / 50.0);
  EXPECT_EQ(figures["way_m"], 17.5);
  EXPECT_EQ(figures["staleness_ms_mean"], 150.0);
  EXPECT_EQ(figures["staleness_ms_p95"], 300.0);
  EXPECT_EQ(figures["scan_age_ms_mean"], 20.0);
  EXPECT_EQ(figures["appearances"], 3.0);
  EXPECT_EQ(figures["reacted"], 2.0);
  EXPECT_EQ(figures["reaction_ms_mean"], 100.0);
  EXPECT_EQ(figures["response_ms_mean scan -> LM"], 17.0);
  EXPECT_EQ(figures["response_ms_p95 scan -> LM"], 19.0);
  EXPECT_EQ(figures["objective_ms"], 1.0 * 17.0 + 0.5 * 20.0);
  EXPECT_FALSE(figures.contains("explored"));
  EXPECT_EQ(json["chains"][0]["predicted_response_ms"], 18.0);
  EXPECT_EQ(json["nodes"]["LM"]["rate_hz"], 50.0);
  ASSERT_EQ(json["staleness_ms_p95_by_5s"].size(), 10U);
  EXPECT_EQ(json["staleness_ms_p95_by_5s"][0], 300.0);
  EXPECT_TRUE(json["staleness_ms_p95_by_5s"][1].is_null());
  EXPECT_EQ(json["staleness_ms_p95_by_5s"][9], 50.0);
}

TEST(Outcome, HasTheDetectorsPeriodWhereThereIsOne) {
  Outcome outcome = sample();
  outcome.findings.detections = {1s, 3s, 7s, 11s};
  EXPECT_FALSE(nlohmann::json::parse(to_json(outcome)).contains("detector_period_ms_by_10s"));
  outcome.options.detector = "hog";
  const auto json = nlohmann::json::parse(to_json(outcome));
  EXPECT_EQ(json["figures"]["detector_outputs"], 4.0);
  EXPECT_NEAR(json["figures"]["detector_period_ms_mean"].get<double>(), 10000.0 / 3.0, 1e-9);
  ASSERT_EQ(json["detector_period_ms_by_10s"].size(), 5U);
  EXPECT_EQ(json["detector_period_ms_by_10s"][0], 3000.0);
  EXPECT_EQ(json["detector_period_ms_by_10s"][1], 4000.0);
  EXPECT_TRUE(json["detector_period_ms_by_10s"][2].is_null());
  EXPECT_NE(to_text(outcome).find("detector_period_ms by 10 s"), std::string::npos);
}

TEST(Outcome, AnObjectiveWithATermThatWasNotMeasuredIsNull) {
  Outcome outcome = sample();
  outcome.snapshot.objective.push_back({"GL -> NC", 0.005, {}});
  EXPECT_TRUE(nlohmann::json::parse(to_json(outcome))["figures"]["objective_ms"].is_null());
}

TEST(Outcome, WhatWasNotMeasuredIsNull) {
  const auto json = nlohmann::json::parse(to_json(Outcome{}));
  EXPECT_TRUE(json["figures"]["staleness_ms_mean"].is_null());
  EXPECT_TRUE(json["figures"]["reaction_ms_p95"].is_null());
  EXPECT_TRUE(json["figures"]["goal_s"].is_null());
  EXPECT_TRUE(nlohmann::json::parse(to_json(sample()))["figures"]["response_ms_mean GL -> NC"].is_null());
}

TEST(Outcome, ACollisionIsNoSuccess) {
  Outcome outcome = sample();
  outcome.findings.contacts.push_back({12s, 1, {3.0, 4.0, 0.0}, 0.5});
  outcome.findings.contacts.push_back({13s, std::nullopt, {3.0, 4.0, 0.0}, 0.5});
  const auto json = nlohmann::json::parse(to_json(outcome));
  EXPECT_EQ(json["figures"]["collided"], 1.0);
  EXPECT_EQ(json["figures"]["contacts"], 2.0);
  EXPECT_EQ(json["figures"]["barn_score"], 0.0);
  EXPECT_EQ(json["contacts"][0]["with"], "mover 1");
  EXPECT_EQ(json["contacts"][0]["at_s"], 12.0);
  EXPECT_EQ(json["contacts"][1]["with"], "wall");
}

TEST(Outcome, OfExplorationHasNoGoal) {
  Outcome outcome = sample();
  outcome.explores = true;
  outcome.shortest_way.reset();
  outcome.findings.explored = 0.93;
  outcome.findings.explored_90_at = 40s;
  const auto json = nlohmann::json::parse(to_json(outcome));
  EXPECT_EQ(json["figures"]["explored"], 0.93);
  EXPECT_EQ(json["figures"]["explored_90_s"], 40.0);
  EXPECT_FALSE(json["figures"].contains("barn_score"));
}

TEST(Outcome, TellsWhatTheWorldsThreadLost) {
  Outcome outcome = sample();
  outcome.world_thread = program::ThreadUse{0.01, 0.5, 0};
  EXPECT_FALSE(nlohmann::json::parse(to_json(outcome))["world_thread"].contains("lost"));
  EXPECT_EQ(to_text(outcome).find("LOST"), std::string::npos);
  outcome.world_thread->lost = 7;
  EXPECT_EQ(nlohmann::json::parse(to_json(outcome))["world_thread"]["lost"], 7);
  EXPECT_NE(to_text(outcome).find("for 7 of"), std::string::npos);
}

TEST(Outcome, TextHasTheFiguresAndTheNodes) {
  const std::string text = to_text(sample());
  EXPECT_NE(text.find("two rooms"), std::string::npos);
  EXPECT_NE(text.find("barn_score"), std::string::npos);
  EXPECT_NE(text.find("in virtual time on 1 core;"), std::string::npos);
  EXPECT_NE(text.find("LM"), std::string::npos);
}

}  // namespace
}  // namespace ctn::navigation::run
