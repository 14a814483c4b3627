#include "web/timeline.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::web {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr TimePoint kStart{std::chrono::seconds{100}};

graph::App eye_and_hand() {
  graph::AppSpec spec = graph::spec_of({"scan", "see", "act", "ext"}, {"scan see act ext"});
  graph::node(spec, "scan").unscheduled = true;
  graph::node(spec, "scan").period = {milliseconds{10}, {}};
  graph::node(spec, "ext").external = true;
  spec.subchains = {graph::subchain("front", "see"), graph::subchain("back", "act")};
  spec.objective = {graph::response("see act", 1.0)};
  return graph::build_app(spec).value();
}

class TimelineTest : public testing::Test {
 protected:
  TimePoint at(int ms) { return kStart + milliseconds{ms}; }
  void ran(const char* node, int begin, int end, int cpu_ms, int on_cpu) {
    record::Run run;
    run.node = *app_.graph.find_node(node);
    run.number = 1;
    run.begin = at(begin);
    run.end = at(end);
    run.cpu = milliseconds{cpu_ms};
    run.on_cpu = on_cpu;
    timeline_.add(run);
  }
  Json shown(int now) { return Json::parse(timeline_.json(at(now))); }
  static Json row(Json cpu, Json busy) { return {{"cpu", std::move(cpu)}, {"busy", std::move(busy)}}; }

  graph::App app_ = eye_and_hand();
  Timeline timeline_{app_, kStart};
};

TEST_F(TimelineTest, ShowsSubchainsAndThenUnscheduledNodes) {
  EXPECT_EQ(shown(0),
            Json::parse(R"({"step_ms": 100.0, "until_s": 0.0, "lanes": ["front", "back", "scan"], "cpus": []})"));
}

TEST_F(TimelineTest, CpuTimeIsSpreadOverTheRun) {
  ran("see", 50, 250, 100, 2);   // half of the time, in three steps
  ran("act", 300, 400, 100, 2);  // all of one step
  ran("scan", 0, 10, 10, 0);
  const Json json = shown(450);
  EXPECT_EQ(json["until_s"], 0.4);
  EXPECT_EQ(json["cpus"], Json::array({row(0, {{{"lane", 2}, {"permille", {100, 0, 0, 0}}}}),
                                       row(2, {{{"lane", 0}, {"permille", {250, 500, 250, 0}}},
                                               {{"lane", 1}, {"permille", {0, 0, 0, 1000}}}})}));
}

TEST_F(TimelineTest, RunsOfALaneAddUp) {
  ran("see", 0, 30, 30, 0);
  ran("see", 40, 100, 30, 0);
  EXPECT_EQ(shown(100)["cpus"][0]["busy"][0]["permille"], Json({600}));
}

TEST_F(TimelineTest, OnlyTheLast30SecondsAreKept) {
  ran("see", 0, 100, 100, 0);
  ran("see", 30'000, 30'100, 100, 0);
  const Json before = shown(30'100)["cpus"][0]["busy"][0]["permille"];
  ASSERT_EQ(before.size(), 300U);
  EXPECT_EQ(before[0], 0);
  EXPECT_EQ(before[299], 1000);
  EXPECT_EQ(shown(60'200)["cpus"][0]["busy"], Json::array());
  // A run of an hour counts for what is kept of it.
  ran("act", 0, 3'600'000, 3'600'000, 1);
  const Json after = shown(3'600'000)["cpus"][1]["busy"][0]["permille"];
  EXPECT_EQ(after, Json(std::vector<int>(300, 1000)));
}

TEST_F(TimelineTest, OddRunsAreLeftOut) {
  ran("see", 100, 100, 1, 0);
  ran("see", 100, 50, 1, 0);
  ran("see", -100, 50, 1, 0);
  ran("ext", 0, 50, 1, 0);
  record::Run unknown;
  unknown.node = NodeId(99);
  unknown.begin = at(0);
  unknown.end = at(1);
  timeline_.add(unknown);
  EXPECT_EQ(shown(1000)["cpus"], Json::array());
  ran("see", 0, 100, 1'000'000, -7);  // more CPU time than there was; a CPU that is not known
  EXPECT_EQ(shown(100)["cpus"], Json::array({row(nullptr, {{{"lane", 0}, {"permille", {1000}}}})}));
}

TEST_F(TimelineTest, CpusAreBounded) {
  for (int cpu = 0; cpu < 1000; ++cpu) ran("see", 0, 100, 100, cpu);
  EXPECT_EQ(shown(100)["cpus"].size(), Timeline::kMaxCpus);
}

TEST_F(TimelineTest, KeepsThePlanInForce) {
  EXPECT_EQ(timeline_.plan(), "");
  timeline_.add(record::PlanChange{.at = at(1), .reason = "bootstrap", .json = "{1}"});
  timeline_.add(record::PlanChange{.at = at(2), .reason = "measured", .json = "{2}"});
  EXPECT_EQ(timeline_.plan(), "{2}");
}

}  // namespace
}  // namespace ctn::web
