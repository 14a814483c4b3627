// Small apps, by hand. Random ones against brute force: tests/paper_property_test.cpp.
#include "paper/paper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "plan/validate.h"

namespace ctn::paper {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Node {
  std::string name;
  double cost = 0.0;
  double weight = 0.0;  // of its period
};

graph::AppSpec spec_of(const std::vector<Node>& nodes) {
  std::vector<std::string> names;
  for (const Node& node : nodes) names.push_back(node.name);
  graph::AppSpec spec = graph::spec_of(names, {});
  for (const Node& node : nodes) spec.objective.push_back(graph::period(node.name, node.weight));
  return spec;
}

struct Made {
  graph::App app;
  model::CostTable costs;
  Result<plan::Plan> plan;
};

Made made(const std::vector<Node>& nodes, const graph::AppSpec& spec, Request request) {
  const Result<graph::App> built = graph::build_app(spec);
  EXPECT_TRUE(built.ok()) << (built.ok() ? "" : built.error().message());
  graph::App app = as_in_the_paper(*built);
  model::CostTable costs(app.graph, Millis{0});
  for (const Node& node : nodes) {
    costs.set(*app.graph.find_node(node.name), model::CostProfile::constant(Millis{node.cost}));
  }
  Result<plan::Plan> plan = make_plan(app, costs, request);
  EXPECT_TRUE(!plan || plan::validate(*plan, app, costs, request.cores).ok());
  return {std::move(app), std::move(costs), std::move(plan)};
}
Made made(const std::vector<Node>& nodes, Request request) { return made(nodes, spec_of(nodes), request); }

const std::vector<Node> kTwo{{"fast", 2.0, 1.0}, {"slow", 8.0, 0.1}};

// (1 + 0.1 n) (2 + 8 / n) is least for n = 6, among whole numbers up to 8 (slices of 1 ms).
TEST(Paper, DividesACoreByWeightsAndCosts) {
  const Made m = made(kTwo, {.cores = 1, .slack = 0.0});
  ASSERT_TRUE(m.plan.ok()) << m.plan.error().message();
  EXPECT_EQ(m.plan->subchains[0].every, 1);
  EXPECT_EQ(m.plan->subchains[1].every, 6);
  EXPECT_NEAR(m.plan->cores[0].frame.count(), 2.0 + 8.0 / 6.0, 1e-9);
  EXPECT_NEAR(m.plan->objective, 1.6 * (2.0 + 8.0 / 6.0), 1e-9);
  EXPECT_EQ(m.plan->quality, plan::Quality::kOptimal);
  EXPECT_EQ(m.plan->planner, "paper");
  EXPECT_EQ(m.plan->cores[0].frames, graph::FrameMode::kFixed);
}

// p_fast + 0.1 p_slow is then least where 2 / p_fast + 8 / p_slow is all of the core: (sqrt(2) + sqrt(0.8))^2.
TEST(Paper, GivesAQueueNodeAnyFraction) {
  graph::AppSpec spec = spec_of(kTwo);
  node(spec, "slow").input = graph::InputKind::kQueue;
  spec.scheduler.min_slice = std::chrono::microseconds{100};
  const Made m = made(kTwo, spec, {.cores = 1, .slack = 0.0});
  ASSERT_TRUE(m.plan.ok()) << m.plan.error().message();
  EXPECT_FALSE(m.plan->subchains[1].every);
  const double min = 2.0 + 0.8 + 2.0 * std::sqrt(1.6);
  EXPECT_NEAR(m.plan->objective, min, 1e-6);
}

// Slow takes what fast gives, and costs more with each item: it has time for as many as its own period brings.
TEST(Paper, GivesTimeForTheItemsThatAPeriodBrings) {
  graph::AppSpec spec = graph::spec_of({"fast", "slow"}, {"fast slow"});
  node(spec, "slow").input = graph::InputKind::kQueue;
  spec.objective = {graph::period("fast", 1.0), graph::period("slow", 0.1)};
  const graph::App app = as_in_the_paper(graph::build_app(spec).value());
  model::CostTable costs(app.graph, Millis{2});
  costs.set(NodeId(1), model::CostProfile::constant(Millis{4}).with_per_item(Millis{0.5}));
  const Result<plan::Plan> plan = make_plan(app, costs, {.cores = 1, .slack = 0.0});
  ASSERT_TRUE(plan.ok()) << plan.error().message();
  const Status valid = plan::validate(*plan, app, costs, 1);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
  ASSERT_EQ(plan->batches.size(), 1U);
  const double items = plan->subchains[1].period / plan->subchains[0].period;
  EXPECT_GE(plan->batches[0].items, items);
  EXPECT_LE(plan->batches[0].items, items * 1.25 + 3.0);
  EXPECT_EQ(plan->quality, plan::Quality::kFeasible) << "of fixed costs alone the stages prove anything";
}

TEST(Paper, GivesCoresToThoseThatGainMost) {
  const std::vector<Node> nodes{{"a", 4.0, 1.0}, {"b", 4.0, 0.1}, {"c", 4.0, 0.1}};
  const Made m = made(nodes, {.cores = 2, .slack = 0.0});
  ASSERT_TRUE(m.plan.ok());
  EXPECT_EQ(m.plan->subchains[0].period, Millis{4}) << "by itself";
  EXPECT_EQ(m.plan->subchains[1].cores, m.plan->subchains[2].cores);
  EXPECT_NE(m.plan->subchains[0].cores, m.plan->subchains[1].cores);
}

TEST(Paper, StageTwoAloneKeepsTheCoresOfAnotherPlan) {
  const std::vector<Node> nodes{{"a", 4.0, 1.0}, {"b", 4.0, 0.1}, {"c", 4.0, 0.1}};
  const Made before = made(nodes, {.cores = 2, .slack = 0.0});
  ASSERT_TRUE(before.plan.ok());
  const std::vector<Node> other{{"a", 4.0, 0.01}, {"b", 4.0, 0.1}, {"c", 4.0, 1.0}};
  const Made again = made(other, {.cores = 2, .slack = 0.0, .allocated = &*before.plan});
  ASSERT_TRUE(again.plan.ok());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_EQ(again.plan->subchains[i].cores, before.plan->subchains[i].cores);
  }
  const Made anew = made(other, {.cores = 2, .slack = 0.0});
  EXPECT_LT(anew.plan->objective, again.plan->objective);
}

// Each third run of slow gives an output, so that its response time is p + 3 p: (1 + 0.4 n) (2 + 8 / n) is least for
// n = 3.
TEST(Paper, WhatGivesFewerOutputsThanItRunsIsRunMoreOften) {
  graph::AppSpec spec = graph::spec_of({"fast", "slow"}, {});
  spec.objective = {graph::period("fast", 1.0), graph::response("slow", 0.1)};
  const graph::App app = as_in_the_paper(graph::build_app(spec).value());
  model::CostTable costs(app.graph, Millis{0});
  costs.set(NodeId(0), model::CostProfile::constant(Millis{2}));
  costs.set(NodeId(1), model::CostProfile::constant(Millis{8}));
  costs.set_runs_per_output(NodeId(1), 3.0);
  const Result<plan::Plan> plan = make_plan(app, costs, {.cores = 1, .slack = 0.0});
  ASSERT_TRUE(plan.ok()) << plan.error().message();
  EXPECT_EQ(plan->subchains[1].every, 3);
  EXPECT_NEAR(plan->objective, 2.2 * (2.0 + 8.0 / 3.0), 1e-9);
  EXPECT_EQ(plan->quality, plan::Quality::kOptimal);
  EXPECT_TRUE(plan::validate(*plan, app, costs, 1).ok());
}

TEST(Paper, RelaxesBoundsByTheLeastFactor) {
  graph::AppSpec spec = spec_of(kTwo);
  node(spec, "fast").min_rate = graph::At<Rate>{Rate::every(Millis{2.5}), {}};
  node(spec, "slow").min_rate = graph::At<Rate>{Rate::every(Millis{10.0}), {}};
  const Made m = made(kTwo, spec, {.cores = 1, .slack = 0.0});
  ASSERT_TRUE(m.plan.ok()) << m.plan.error().message();
  // n = 4: a frame of 4 ms, and factors of 1.6 for both.
  EXPECT_NEAR(m.plan->relax_factor, 1.6, 1e-8);
  EXPECT_EQ(m.plan->subchains[1].every, 4);
  EXPECT_EQ(m.plan->relaxed.size(), 2U);
}

TEST(Paper, ExactRatesSetTheFrame) {
  graph::AppSpec spec = spec_of(kTwo);
  node(spec, "fast").min_rate = node(spec, "fast").max_rate = graph::At<Rate>{Rate::every(Millis{10.0}), {}};
  const Made m = made(kTwo, spec, {.cores = 1, .slack = 0.0});
  ASSERT_TRUE(m.plan.ok()) << m.plan.error().message();
  EXPECT_EQ(m.plan->subchains[0].period, Millis{10});
  EXPECT_EQ(m.plan->subchains[1].period, Millis{10});
}

TEST(Paper, SaysWhichExactRatesCannotBeMet) {
  graph::AppSpec spec = spec_of(kTwo);
  node(spec, "fast").min_rate = node(spec, "fast").max_rate = graph::At<Rate>{Rate::every(Millis{2.1}), {}};
  const Made m = made(kTwo, spec, {.cores = 1, .slack = 0.0});
  ASSERT_FALSE(m.plan.ok());
  EXPECT_THAT(m.plan.error().message(), HasSubstr("exact rates of fast"));
}

TEST(Paper, RefusesWhatIsNoMachine) {
  EXPECT_THAT(made(kTwo, {.cores = 0}).plan.error().message(), HasSubstr("cores"));
  EXPECT_THAT(made(kTwo, {.cores = 1, .slack = 1.0}).plan.error().message(), HasSubstr("slack"));
}

}  // namespace
}  // namespace ctn::paper
