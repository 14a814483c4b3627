#include "sim/whatif.h"

#include <gtest/gtest.h>

#include "config/testing/apps.h"
#include "planner/formulas.h"

namespace ctn::sim {
namespace {

// A loop that must answer within 40 ms, and a long node that is not part of it.
class WhatIfTest : public ::testing::Test {
 protected:
  WhatIfTest() {
    set("fast", 4.0);
    set("slow", 30.0);
    options.policy = *policy::make_policy("catan");
    options.seconds = 2.0;
  }
  void set(const char* node, double ms) { work.set(id(node), model::NodeWork::constant(Millis{ms})); }
  NodeId id(const char* node) const { return *app.graph.find_node(node); }
  bool plan_holds(const Hypothesis& asked) const {
    const auto changed = work_under(app, work, asked);
    const model::CostTable costs = changed.costs(app.graph);
    const auto holds = [](const auto& plan) { return plan.ok() && plan->relax_factor <= 1.0; };
    return holds(planner::make_plan_by_formulas(app, costs, {.cores = asked.cores, .guesses = 20'000})) ||
           holds(planner::make_guessed_plan(app, trial::Samples(app, changed, Nanos{0}, 1), costs,
                                            {.cores = asked.cores, .guesses = 20'000}));
  }

  graph::App app = parse(R"(
catan: 1
app: loops
nodes: { fast: { fallback_rate: 50Hz }, slow: { min_rate: 2Hz, fallback_rate: 5Hz } }
objective:
  - { response_time: [fast], weight: 1, max: 40ms }
  - { response_time: [slow], weight: 0.1 }
)");
  model::Workload work{app.graph};
  WhatIfOptions options;
};

TEST_F(WhatIfTest, AHypothesisChangesWhatItSaysAndNothingElse) {
  const auto changed = work_under(app, work, {.speed = 2.0, .node = id("slow"), .factor = 3.0});
  EXPECT_EQ(changed[id("fast")].cost.modes()[0].cost, Millis{2.0});
  EXPECT_EQ(changed[id("slow")].cost.modes()[0].cost, Millis{45.0});
  const graph::App other = app_under(app, {.term = 1, .weight = 7.0});
  EXPECT_EQ(other.objective[1].weight, 7.0);
  EXPECT_EQ(other.objective[0].weight, 1.0);
}

TEST_F(WhatIfTest, FasterCoresAnswerSoonerAndTheCheapestThatHoldsIsFound) {
  const auto answers = answer(
      app, work,
      {{.cores = 1, .speed = 0.1}, {.cores = 1, .speed = 1.0}, {.cores = 1, .speed = 2.0}, {.cores = 2, .speed = 1.0}},
      options);
  ASSERT_TRUE(answers.ok());
  const std::vector<Answer>& all = *answers;
  EXPECT_FALSE(all[0].promise_holds()) << "a run of fast alone takes 40 ms";
  EXPECT_FALSE(all[0].simulation_holds());
  for (const std::size_t index : {1U, 2U, 3U}) {
    ASSERT_TRUE(all[index].promised && all[index].simulated) << all[index].why_not;
    EXPECT_TRUE(all[index].holds()) << index;
    // By a plan of its own, which has the same bound.
    EXPECT_LE(all[index].simulated->chains[0].response_ms.p99, 40.0) << index;
  }
  EXPECT_LT(all[2].simulated->chains[0].response_ms.mean, 0.6 * all[1].simulated->chains[0].response_ms.mean);
  EXPECT_EQ(cheapest(all), &all[1]);
}

// Near a limit guesses find the plan that just holds, or they do not.
TEST_F(WhatIfTest, LimitsLieWherePlansStopHolding) {
  constexpr double kNear = 1.1;
  const auto speed = min_speed(app, work, 1);
  ASSERT_TRUE(speed);
  EXPECT_TRUE(plan_holds({.speed = *speed * kNear}));
  EXPECT_FALSE(plan_holds({.speed = *speed / kNear}));
  const auto factor = max_factor(app, work, {.cores = 1}, id("slow"));
  ASSERT_TRUE(factor);
  EXPECT_TRUE(plan_holds({.node = id("slow"), .factor = *factor / kNear}));
  EXPECT_FALSE(plan_holds({.node = id("slow"), .factor = *factor * kNear}));
  EXPECT_LT(*min_speed(app, work, 2), *speed);
}

TEST_F(WhatIfTest, SaysTheSameHoweverManyThreadsAsk) {
  const std::vector<Hypothesis> asked{{.cores = 1}, {.cores = 2}, {.cores = 1, .speed = 0.5}, {.cores = 3}};
  options.threads = 1;
  const auto one = *answer(app, work, asked, options);
  options.threads = 4;
  std::size_t told = 0;
  options.on_progress = [&](std::size_t done) { told = done; };
  const auto four = *answer(app, work, asked, options);
  EXPECT_EQ(told, asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_EQ(one[i].simulated->chains[0].response_ms.mean, four[i].simulated->chains[0].response_ms.mean);
    EXPECT_EQ(one[i].simulated->objective, four[i].simulated->objective);
  }
}

TEST_F(WhatIfTest, HandSetRatesPromiseNothingAndAreSimulated) {
  options.policy = *policy::make_policy("default");
  const auto answers = answer(app, work, {{.cores = 1}}, options);
  ASSERT_TRUE(answers.ok());
  EXPECT_FALSE(answers->front().promised);
  ASSERT_TRUE(answers->front().simulated);
}

TEST_F(WhatIfTest, AppsThatListTheirCoresAreRefused) {
  const graph::App kinds = parse(R"(
catan: 1
app: kinds
cores: { big: { count: 1 }, little: { count: 1, speed: 0.5 } }
nodes: { fast: {} }
objective: [ { response_time: [fast], weight: 1 } ]
)");
  EXPECT_FALSE(answer(kinds, model::Workload(kinds.graph), {{.cores = 2}}, options).ok());
}

}  // namespace
}  // namespace ctn::sim
