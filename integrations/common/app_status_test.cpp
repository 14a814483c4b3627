#include "common/app_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace catan_ros {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using Level = Diagnostic::Level;

json summary(double mean, double p95) {
  return {{"count", 9}, {"mean", mean}, {"p50", mean}, {"p95", p95}, {"p99", p95}, {"max", p95}};
}

json chain(const std::string& path) {
  return {{"path", path},
          {"weight", 1.0},
          {"bound_ms", nullptr},
          {"expected_ms", 20.0},
          {"promised_ms", 50},
          {"newest_ms", 21.5},
          {"over_bound", 0},
          {"over_promise", 0},
          {"late_by", json::object()},
          {"response_ms", summary(22.25, 30.0)}};
}

json node(const std::string& name) {
  return {{"node", name},
          {"runs", 100},
          {"rate_hz", 10.0},
          {"expected_hz", 10.0},
          {"period_ms", summary(100.0, 120.0)},
          {"compute_ms", summary(5.0, 6.0)},
          {"cores", 0.05},
          {"silent_ms", 40.0},
          {"absent", false}};
}

// An app with which nothing is wrong.
json sound() {
  return {{"app", "robot"},
          {"scheduler", "catan"},
          {"real_time", true},
          {"cpus", {0, 1}},
          {"state", "running"},
          {"up_s", 12.5},
          {"objective", 22.25},
          {"plans_made", 3},
          {"planning_ms", 41.5},
          {"starved", 0},
          {"notices", json::array()},
          {"plan",
           {{"at_s", 2.0},
            {"reason", "measured"},
            {"planner", "auto"},
            {"objective", 20.0},
            {"relax_factor", 1.0},
            {"relaxed", json::array()},
            {"assumed", json::array()}}},
          {"chains", {chain("scan -> LM -> LP")}},
          {"subchains",
           {{{"subchain", "local"},
             {"cores", {0}},
             {"sharing", "priorities"},
             {"priority", 2},
             {"expected_period_ms", 100.0},
             {"budget_ms", 12.0},
             {"late", 0},
             {"stole", 0},
             {"overruns", 0},
             {"period_ms", summary(100.0, 120.0)},
             {"used_ms", summary(5.0, 6.0)}}}},
          {"nodes", {node("LM")}}};
}

Diagnostic find(const json& live, const std::string& name) {
  const std::vector<Diagnostic> all = diagnostics_of(live);
  const auto found = std::find_if(all.begin(), all.end(), [&](const Diagnostic& one) { return one.name == name; });
  return found == all.end() ? Diagnostic{} : *found;
}

TEST(AppStatus, NothingIsWrongWithASoundApp) {
  std::vector<std::string> names;
  for (const Diagnostic& diagnostic : diagnostics_of(sound())) {
    EXPECT_EQ(diagnostic.level, Level::kOk) << diagnostic.name << ": " << diagnostic.message;
    names.push_back(diagnostic.name);
  }
  EXPECT_THAT(names, ElementsAre("app", "plan", "chain scan -> LM -> LP", "subchain local", "node LM"));
  EXPECT_EQ(find(sound(), "app").message, "robot is running");
  EXPECT_THAT(find(sound(), "chain scan -> LM -> LP").values, Contains(Pair("response ms mean", "22.25")));
  EXPECT_THAT(find(sound(), "chain scan -> LM -> LP").values, Contains(Pair("bound_ms", "-")));
  EXPECT_THAT(find(sound(), "subchain local").values, Contains(Pair("sharing", "priorities")));
  EXPECT_THAT(find(sound(), "node LM").values, Contains(Pair("rate_hz", "10")));
}

TEST(AppStatus, AnAppThatIsKilledIsAnErrorAndItsNodesAreNot) {
  json live = sound();
  live["state"] = "killed";
  live["nodes"][0]["silent_ms"] = 60'000.0;
  live["notices"].push_back({{"at_s", 3.0}, {"kind", "relaxed"}, {"detail", "the bound is relaxed"}});
  EXPECT_EQ(find(live, "app").level, Level::kError);
  EXPECT_EQ(find(live, "app").message, "robot is killed");
  EXPECT_THAT(find(live, "app").values, Contains(Pair("last notice", "the bound is relaxed")));
  EXPECT_EQ(find(live, "node LM").level, Level::kOk);
  EXPECT_EQ(diagnostic_of_no_app("there is none").level, Level::kError);
}

TEST(AppStatus, LevelsThatAreNotSetAreAWarning) {
  json live = sound();
  live["real_time"] = false;
  EXPECT_EQ(find(live, "app").level, Level::kWarning);
  EXPECT_THAT(find(live, "app").message, HasSubstr("without real-time levels"));
}

TEST(AppStatus, APlanThatRelaxesOrAssumesIsAWarning) {
  json live = sound();
  live["plan"]["relaxed"].push_back({{"bound", "objective[0].max"}, {"asked_ms", 30.0}, {"planned_ms", 41.25}});
  live["plan"]["assumed"].push_back({{"node", "GL"}, {"cost_ms", 5.0}});
  EXPECT_EQ(find(live, "plan").level, Level::kWarning);
  EXPECT_EQ(find(live, "plan").message, "objective[0].max is relaxed from 30 to 41.25 ms, GL had not run");
  live["plan"] = nullptr;
  EXPECT_EQ(find(live, "plan").level, Level::kOk);
  EXPECT_THAT(find(live, "plan").message, HasSubstr("those of the app file"));
}

TEST(AppStatus, LateResponsesAreAWarningOverTheBoundOrElseThePromise) {
  json live = sound();
  live["chains"][0]["over_promise"] = 1;
  live["chains"][0]["late_by"] = {{"pre-empted", 1}};
  EXPECT_EQ(find(live, "chain scan -> LM -> LP").level, Level::kWarning);
  EXPECT_EQ(find(live, "chain scan -> LM -> LP").message, "1 response was longer than was promised");
  EXPECT_THAT(find(live, "chain scan -> LM -> LP").values, Contains(Pair("late by: pre-empted", "1")));
  live["chains"][0]["bound_ms"] = 100.0;
  EXPECT_EQ(find(live, "chain scan -> LM -> LP").level, Level::kOk) << "within its bound";
  live["chains"][0]["over_bound"] = 3;
  EXPECT_EQ(find(live, "chain scan -> LM -> LP").message, "3 responses were over the bound");
}

TEST(AppStatus, RunsThatWereDemotedAreAWarning) {
  json live = sound();
  live["subchains"][0]["overruns"] = 2;
  EXPECT_EQ(find(live, "subchain local").level, Level::kWarning);
  EXPECT_EQ(find(live, "subchain local").message, "2 runs were demoted, over the budget");
}

TEST(AppStatus, ANodeThatIsAbsentIsAnError) {
  json live = sound();
  live["nodes"][0]["silent_ms"] = 5'100.0;
  EXPECT_EQ(find(live, "node LM").level, Level::kOk);
  live["nodes"][0]["absent"] = true;
  EXPECT_EQ(find(live, "node LM").level, Level::kError);
  EXPECT_EQ(find(live, "node LM").message, "has not run for 5.1 s");
  live["nodes"][0]["silent_ms"] = nullptr;
  live["nodes"][0]["compute_ms"] = nullptr;
  EXPECT_EQ(find(live, "node LM").level, Level::kError);
  EXPECT_EQ(find(live, "node LM").message, "has not run");
}

TEST(AppStatus, ResponseTimesHaveNamesThatTopicsMayHave) {
  json live = sound();
  live["chains"].push_back(chain("scan -> LM+LP"));
  live["chains"].push_back(chain("scan -> LM -> LP"));
  live["chains"][2]["response_ms"] = nullptr;
  const std::vector<ResponseTime> times = response_times_of(live);
  ASSERT_EQ(times.size(), 3U);
  EXPECT_EQ(times[0].name, "scan_LM_LP");
  EXPECT_EQ(times[0].mean_ms, 22.25);
  EXPECT_EQ(times[0].p95_ms, 30.0);
  EXPECT_EQ(times[1].name, "scan_LM_LP_2");
  EXPECT_EQ(times[2].name, "scan_LM_LP_3");
  EXPECT_EQ(times[2].mean_ms, std::nullopt);
}

json asked() {
  return {{"objective",
           {{{"term", "scan -> LM"}, {"weight", 1.0}, {"max_ms", 40.0}},
            {{"term", "period of GL"}, {"weight", 0.5}, {"max_ms", nullptr}}}},
          {"nodes", {{{"name", "GL"}, {"min_rate_hz", nullptr}}, {{"name", "LM"}, {"min_rate_hz", 5.0}}}}};
}

TEST(AppStatus, SettingsAreWeightsBoundsAndLowestRates) {
  std::vector<std::string> settings;
  for (const Setting& one : settings_of(asked())) settings.push_back(one.name + " = " + std::to_string(one.value));
  EXPECT_THAT(settings,
              ElementsAre("weight_scan_LM = 1.000000", "max_ms_scan_LM = 40.000000", "weight_period_of_GL = 0.500000",
                          "min_rate_hz_GL = 0.000000", "min_rate_hz_LM = 5.000000"));
}

TEST(AppStatus, ChangesAreWhatIsOfAnotherValue) {
  std::vector<std::string> unknown;
  const ctn::Changes changes = changes_to(settings_of(asked()),
                                          {{"weight_scan_LM", 1.0},
                                           {"weight_period_of_GL", 0.25},
                                           {"max_ms_scan_LM", 0.0},
                                           {"min_rate_hz_GL", 2.0},
                                           {"speed", 1.0}},
                                          unknown);
  EXPECT_THAT(unknown, ElementsAre("speed"));
  EXPECT_THAT(changes.weights, ElementsAre(ctn::Changes::Weight{"1", 0.25}));
  EXPECT_THAT(changes.maxes, ElementsAre(ctn::Changes::Max{"0", std::nullopt}));
  EXPECT_THAT(changes.min_rates, ElementsAre(ctn::Changes::MinRate{"GL", 2.0}));
  EXPECT_EQ(changes_to(settings_of(asked()), {{"weight_scan_LM", 1.0}}, unknown), ctn::Changes{});
}

}  // namespace
}  // namespace catan_ros
