#include "planner/planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "graph/build.h"
#include "graph/spec_text.h"
#include "plan/validate.h"

namespace ctn::planner {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

graph::AppSpec face_tracking() {
  graph::AppSpec spec = graph::spec_of({"camera", "detect", "plan", "motor"}, {"camera detect plan motor"});
  node(spec, "motor").external = true;
  spec.subchains = {graph::subchain("track", "camera detect plan")};
  spec.objective = {graph::response("camera detect plan motor", 1.0)};
  return spec;
}

graph::App build(const graph::AppSpec& spec) {
  auto app = graph::build_app(spec);
  EXPECT_TRUE(app.ok()) << (app.ok() ? "" : app.error().message());
  return *std::move(app);
}

model::CostTable costs_of(const graph::App& app, double camera, double detect, double plan) {
  model::CostTable costs(app.graph, Millis{0});
  costs.set(*app.graph.find_node("camera"), model::CostProfile::constant(Millis{camera}));
  costs.set(*app.graph.find_node("detect"), model::CostProfile::constant(Millis{detect}));
  costs.set(*app.graph.find_node("plan"), model::CostProfile::constant(Millis{plan}));
  return costs;
}

graph::At<Rate> at_hertz(double rate) { return {Rate{rate}, {}}; }

// The plan for costs of 25, 58 and 1 ms, proven valid.
plan::Plan plan_for(const graph::AppSpec& spec, const Request& request) {
  const graph::App app = build(spec);
  const model::CostTable costs = costs_of(app, 25, 58, 1);
  auto plan = make_plan(app, costs, request);
  EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().message());
  const Status valid = plan::validate(*plan, app, costs, request.cores);
  EXPECT_TRUE(valid.ok()) << (valid.ok() ? "" : valid.error().message());
  return *std::move(plan);
}

std::string refusal(const graph::AppSpec& spec, const Request& request) {
  const graph::App app = build(spec);
  const auto plan = make_plan(app, costs_of(app, 25, 58, 1), request);
  if (plan) return "";
  EXPECT_EQ(plan.error().kind(), ErrorKind::kCaller);
  return plan.error().message();
}

TEST(Planner, OnOneCoreRunsOneRunAfterTheOther) {
  const plan::Plan plan = plan_for(face_tracking(), {1, 0.0});
  EXPECT_EQ(plan.planner, "joint");
  EXPECT_EQ(plan.quality, plan::Quality::kOptimal);
  EXPECT_EQ(plan.gap, 0.0);
  EXPECT_EQ(plan.solve_time, Millis{0});
  EXPECT_THAT(plan.subchains[0].cores, ElementsAre(0));
  EXPECT_DOUBLE_EQ(plan.subchains[0].period.count(), 84.0);
  EXPECT_DOUBLE_EQ(plan.chains[0].response.count(), 168.0);
  EXPECT_DOUBLE_EQ(plan.objective, 168.0);
  EXPECT_THAT(plan.relaxed, IsEmpty());
}

TEST(Planner, OnTwoCoresRunsOverlap) {
  const plan::Plan plan = plan_for(face_tracking(), {2, 0.06});
  EXPECT_THAT(plan.subchains[0].cores, ElementsAre(0, 1));
  EXPECT_DOUBLE_EQ(plan.subchains[0].period.count(), 58.0 / 0.94);
  EXPECT_DOUBLE_EQ(plan.chains[0].response.count(), 84.0 + 58.0 / 0.94);
}

TEST(Planner, LeavesCoresThatAreOfNoUse) {
  // From the second core on the longest node binds.
  const plan::Plan plan = plan_for(face_tracking(), {8, 0.06});
  EXPECT_THAT(plan.subchains[0].cores, ElementsAre(0, 1));
  EXPECT_EQ(plan.cores.size(), 8U);
}

TEST(Planner, NodesThatUseSeveralCoresAreGivenThem) {
  graph::AppSpec spec = face_tracking();
  node(spec, "detect").max_threads = graph::At<int>{4, {}};
  const plan::Plan plan = plan_for(spec, {4, 0.0});
  // q = 4: p = L = 25 + 14.5 + 1; q = 2: p = 29, L = 55; q = 3: p = L = 25 + 58 / 3 + 1; q = 1: p = 58, L = 84.
  EXPECT_EQ(plan.subchains[0].threads, 4);
  EXPECT_DOUBLE_EQ(plan.subchains[0].period.count(), 40.5);
  EXPECT_DOUBLE_EQ(plan.subchains[0].execution.count(), 40.5);
}

TEST(Planner, SaysWhichMethodWasAskedFor) {
  EXPECT_EQ(plan_for(face_tracking(), {1, 0.06, Method::kTwoStage}).planner, "two-stage");
}

TEST(Planner, AMaxRateStretchesThePeriod) {
  graph::AppSpec spec = face_tracking();
  node(spec, "detect").max_rate = at_hertz(5);
  const plan::Plan plan = plan_for(spec, {2, 0.06});
  EXPECT_EQ(plan.subchains[0].period, Millis{200});
  EXPECT_THAT(plan.subchains[0].cores, ElementsAre(0)) << "the second core is of no use at 5 Hz";
}

TEST(Planner, AnExactRateIsThePeriod) {
  graph::AppSpec spec = face_tracking();
  node(spec, "detect").min_rate = node(spec, "detect").max_rate = at_hertz(10);
  EXPECT_EQ(plan_for(spec, {2, 0.06}).subchains[0].period, Millis{100});
}

TEST(Planner, AnExactRateTakesTheCoresItNeeds) {
  graph::AppSpec spec = face_tracking();
  node(spec, "detect").min_rate = node(spec, "detect").max_rate = at_hertz(16);
  const plan::Plan plan = plan_for(spec, {4, 0.06});
  EXPECT_EQ(plan.subchains[0].period, Millis{62.5});
  EXPECT_THAT(plan.subchains[0].cores, ElementsAre(0, 1));
}

TEST(Planner, AnExactRateOutOfReachIsRefusedWithWhatIsMissing) {
  graph::AppSpec spec = face_tracking();
  node(spec, "detect").min_rate = node(spec, "detect").max_rate = at_hertz(50);
  const std::string message = refusal(spec, {1, 0.0});
  EXPECT_THAT(message, HasSubstr("nodes.detect.min_rate: exactly 50Hz asks for a run every 20ms"));
  EXPECT_THAT(message, HasSubstr("with 1 core and 0 % slack the least possible period is 84ms: 64ms too long"));
  EXPECT_THAT(message, HasSubstr("ask for at most 11.9048Hz"));
}

TEST(Planner, BoundsGiveWayByOneFactor) {
  graph::AppSpec spec = face_tracking();
  spec.objective[0].max = graph::At<Nanos>{std::chrono::milliseconds{84}, {}};
  node(spec, "plan").min_rate = at_hertz(1000.0 / 60.0);
  const plan::Plan plan = plan_for(spec, {1, 0.0});
  EXPECT_DOUBLE_EQ(plan.relax_factor, 2.0);
  ASSERT_EQ(plan.relaxed.size(), 2U);
  EXPECT_EQ(plan.relaxed[0].key, "objective[0].max");
  EXPECT_DOUBLE_EQ(plan.relaxed[0].planned.count(), 168.0);
  EXPECT_EQ(plan.relaxed[1].key, "nodes.plan.min_rate");
  EXPECT_DOUBLE_EQ(plan.relaxed[1].asked.count(), 60.0);
  EXPECT_DOUBLE_EQ(plan.relaxed[1].planned.count(), 84.0);
}

TEST(Planner, ACapOutranksABound) {
  graph::AppSpec spec = face_tracking();
  node(spec, "camera").max_rate = at_hertz(5);
  spec.objective[0].max = graph::At<Nanos>{std::chrono::milliseconds{142}, {}};
  const plan::Plan plan = plan_for(spec, {2, 0.06});
  EXPECT_EQ(plan.subchains[0].period, Millis{200});
  EXPECT_DOUBLE_EQ(plan.relax_factor, 2.0);
}

// By L + p two threads a node would win (14 + 14 against 10 + 20); a bound on the rate that only one thread meets
// counts first.
TEST(Planner, ABoundChoosesTheNumberOfThreads) {
  graph::AppSpec spec = face_tracking();
  const auto plan_with = [&](bool bound) {
    if (bound) node(spec, "camera").min_rate = at_hertz(1000.0 / 12.0);
    const graph::App app = build(spec);
    model::CostTable costs = costs_of(app, 0, 0, 0);
    for (const char* name : {"camera", "detect"}) {
      costs.set(*app.graph.find_node(name), model::CostProfile::of_threads({{1, Millis{10}}, {2, Millis{7}}}));
    }
    const plan::Plan plan = make_plan(app, costs, {2, 0.0}).value();
    EXPECT_TRUE(plan::validate(plan, app, costs, 2).ok());
    return plan;
  };
  EXPECT_EQ(plan_with(false).subchains[0].threads, 2);
  EXPECT_EQ(plan_with(true).subchains[0].threads, 1);
  EXPECT_EQ(plan_with(true).relax_factor, 1.0);
}

TEST(Planner, UnscheduledNodesArePartOfTheirChains) {
  graph::AppSpec spec = face_tracking();
  spec.nodes.emplace_back().name.value = "imu";
  node(spec, "imu").unscheduled = true;
  node(spec, "imu").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  spec.edges.push_back({graph::split("imu plan"), {}});
  spec.objective.push_back(graph::response("imu plan motor", 1.0));
  const graph::App app = build(spec);
  model::CostTable costs = costs_of(app, 25, 58, 1);
  costs.set(*app.graph.find_node("imu"), model::CostProfile::constant(Millis{0.5}));
  const plan::Plan plan = make_plan(app, costs, {1, 0.0}).value();
  EXPECT_TRUE(plan::validate(plan, app, costs, 1).ok());
  EXPECT_DOUBLE_EQ(plan.chains[1].latency.count(), 0.5 + 84 + 84);
  EXPECT_DOUBLE_EQ(plan.chains[1].response.count(), 0.5 + 84 + 84 + 84);
}

TEST(Planner, AQueueNodeHasNoEvery) {
  graph::AppSpec spec = face_tracking();
  node(spec, "camera").input = graph::InputKind::kQueue;
  EXPECT_EQ(plan_for(spec, {1, 0.06}).subchains[0].every, std::nullopt);
}

TEST(Planner, WhatCostsNothingHasNoPeriod) {
  const graph::App app = build(face_tracking());
  const model::CostTable costs(app.graph, Millis{0});
  const plan::Plan plan = make_plan(app, costs, {2, 0.06}).value();
  EXPECT_EQ(plan.subchains[0].period, Millis{0});
  EXPECT_TRUE(plan::validate(plan, app, costs, 2).ok());
}

TEST(Planner, RefusesCoresAndSlackOutOfRange) {
  EXPECT_THAT(refusal(face_tracking(), {0, 0.06}), HasSubstr("cores: there are 0 cores"));
  EXPECT_THAT(refusal(face_tracking(), {-1, 0.06}), HasSubstr("cores"));
  EXPECT_THAT(refusal(face_tracking(), {kMaxCores + 1, 0.06}), HasSubstr("cores"));
  for (const double slack : {-0.01, 1.0, 2.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(refusal(face_tracking(), {1, slack}), HasSubstr("slack"));
  }
}

// camera and detect are one subchain, plan another.
graph::AppSpec seeing_and_planning() {
  graph::AppSpec spec = face_tracking();
  spec.subchains = {graph::subchain("see", "camera detect")};
  return spec;
}

TEST(Planner, EnoughCoresAreOwned) {
  const plan::Plan plan = plan_for(seeing_and_planning(), {2, 0.0});
  EXPECT_THAT(plan.subchains[0].cores, ElementsAre(0));
  EXPECT_THAT(plan.subchains[1].cores, ElementsAre(1));
  EXPECT_THAT(plan.cores[0].slots, IsEmpty());
  // 83, then 1 + 1, and the longer period of the two.
  EXPECT_DOUBLE_EQ(plan.objective, 83.0 + 1.0 + 1.0 + 83.0);
}

TEST(Planner, OneCoreIsShared) {
  const plan::Plan plan = plan_for(seeing_and_planning(), {1, 0.0});
  EXPECT_EQ(plan.cores[0].slots.size(), 2U);
  // A slice of `plan` is a millisecond at least: it has a whole run in every frame, `see` a part of one.
  EXPECT_EQ(plan.subchains[1].every, 1);
  EXPECT_EQ(plan.cores[0].frame, plan.cores[0].slots[0].slice + plan.cores[0].slots[1].slice);
}

TEST(Planner, AnExactRateFixesTheFrame) {
  graph::AppSpec spec = seeing_and_planning();
  node(spec, "plan").min_rate = node(spec, "plan").max_rate = at_hertz(100.0);
  const plan::Plan plan = plan_for(spec, {1, 0.05});
  EXPECT_EQ(plan.cores[0].frames, graph::FrameMode::kFixed);
  EXPECT_NEAR(plan.cores[0].frame.count(), 10.0, 1e-9);
  EXPECT_NEAR(plan.subchains[1].period.count(), 10.0, 1e-9);
  EXPECT_GE(plan.cores[0].idle.count(), 0.0);
}

TEST(Planner, MoreExactRatesThanThereIsCpuAreRefusedWithWhatIsMissing) {
  graph::AppSpec spec = seeing_and_planning();
  node(spec, "camera").min_rate = node(spec, "camera").max_rate = at_hertz(15.0);
  const std::string message = refusal(spec, {1, 0.0});
  EXPECT_THAT(message, HasSubstr("they need 124.5 % of a core, of 100 % that there is; 24.5 % of a core is missing"));
  EXPECT_THAT(message, HasSubstr("give it 3 cores"));
}

TEST(Planner, RefusesMoreSubchainsThanItPlansFor) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i <= kMostSubchains; ++i) names.push_back("n" + std::to_string(i));
  graph::AppSpec spec = graph::spec_of(names, {});
  spec.objective = {graph::period("n0", 1.0)};
  const graph::App app = build(spec);
  const auto plan = make_plan(app, model::CostTable(app.graph, Millis{1}), {});
  ASSERT_FALSE(plan.ok());
  EXPECT_THAT(plan.error().message(), HasSubstr("the app has 257 subchains"));
}

TEST(Planner, RefusesWeightsBeyondArithmetic) {
  graph::AppSpec spec = face_tracking();
  spec.objective[0].weight.value = 1e308;
  EXPECT_THAT(refusal(spec, {1, 0.06}), HasSubstr("scale all weights down"));
  graph::AppSpec two = seeing_and_planning();
  two.objective[0].weight.value = 1e308;
  EXPECT_THAT(refusal(two, {1, 0.06}), HasSubstr("scale all weights down"));
}

}  // namespace
}  // namespace ctn::planner
