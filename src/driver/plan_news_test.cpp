// What is told of plans: once when it begins, when it changes much, and when it ends.
#include "driver/plan_news.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "plan/above_promise.h"

namespace ctn::driver {
namespace {

using News = std::vector<PlanNews::Notice>;

graph::App two(const std::string& a = "{}") {
  return parse("catan: 1\napp: two\nnodes: { a: " + a + ", b: {} }\nedges: [ a -> b ]\nobjective:\n" +
               "  - { response_time: [a, b], weight: 1, max: 40ms }\n");
}

plan::Plan relaxed(double planned) {
  plan::Plan plan;
  plan.relax_factor = planned / 40.0;
  plan.relaxed.push_back({"objective[0].max", Millis{40}, Millis{planned}});
  return plan;
}

TEST(PlanNews, RelaxedBoundsAreToldWhenTheyBeginChangeMuchAndEnd) {
  const graph::App app = two();
  PlanNews news(app);
  EXPECT_EQ(news.in_force({}), News{});
  const News begun = news.in_force(relaxed(50.0));
  ASSERT_EQ(begun.size(), 1U);
  EXPECT_EQ(begun[0].kind, "relaxed");
  EXPECT_NE(begun[0].detail.find("by a factor of 1.25: objective[0].max: 50 ms, not 40 ms"), std::string::npos)
      << begun[0].detail;
  EXPECT_EQ(news.in_force(relaxed(54.0)), News{}) << "not much more";
  EXPECT_EQ(news.in_force(relaxed(46.0)), News{}) << "nor less, than was told";
  EXPECT_EQ(news.in_force(relaxed(60.0)).size(), 1U);
  EXPECT_EQ(news.in_force(relaxed(60.0)), News{});
  EXPECT_EQ(news.in_force({}), (News{{"relaxed", "all bounds hold again"}}));
  EXPECT_EQ(news.in_force({}), News{});
}

TEST(PlanNews, AnotherBoundThatGivesWayMuchIsToldAndOneThatDoesHardlyIsNot) {
  const graph::App app = two();
  PlanNews news(app);
  news.in_force(relaxed(50.0));
  plan::Plan both = relaxed(50.0);
  both.relaxed.push_back({"nodes.b.min_rate", Millis{100}, Millis{105}});
  EXPECT_EQ(news.in_force(both), News{});
  both.relaxed.back().planned = Millis{125};
  const News told = news.in_force(both);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].detail.find("nodes.b.min_rate: 8 Hz, not 10 Hz"), std::string::npos) << told[0].detail;
}

TEST(PlanNews, NodesWhoseCostsAreAssumedAreNamedOnceAndWhenTheyAreKnown) {
  const graph::App app = two();
  PlanNews news(app);
  plan::Plan plan;
  plan.assumed = {{NodeId(1), Millis{5}}};
  const News told = news.in_force(plan);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].kind, "assumed-costs");
  EXPECT_NE(told[0].detail.find("b (5 ms)"), std::string::npos) << told[0].detail;
  EXPECT_EQ(news.in_force(plan), News{});
  EXPECT_EQ(news.in_force({}), (News{{"assumed-costs", "compute times are known now of: b"}}));
  EXPECT_EQ(news.in_force({}), News{});
}

TEST(PlanNews, OfABootstrapPlanNothingIsToldButWhatExactRatesCost) {
  const graph::App app = two("{ min_rate: 100Hz, max_rate: 100Hz }");
  PlanNews news(app);
  plan::Plan guess = relaxed(50.0);
  guess.assumed = {{NodeId(0), Millis{5}}, {NodeId(1), Millis{5}}};
  EXPECT_EQ(news.in_force(guess), News{});
  plan::Plan lower = guess;
  for (plan::AssumedCost& assumed : lower.assumed) assumed.cost = Millis{2.5};
  const News lowered = news.in_force(lower);
  ASSERT_EQ(lowered.size(), 1U);
  EXPECT_EQ(lowered[0].kind, "assumed-costs");
  EXPECT_EQ(news.in_force(lower), News{});
  guess.relaxed.push_back({"nodes.a.min_rate", Millis{10}, Millis{20}});
  ASSERT_EQ(news.in_force(guess).size(), 1U);
  EXPECT_EQ(news.in_force({}), (News{{"assumed-costs", "the compute times of all nodes are known now"},
                                     {"relaxed", "all bounds hold again"}}));
}

TEST(PlanNews, ChainsThatAreExpectedToTakeLongerThanPromisedAreToldOnce) {
  const graph::App app = two();
  PlanNews news(app);
  plan::Plan plan;
  plan.chains.push_back({{NodeId(0), NodeId(1)}, Millis{23.2}, {}, {}, 1.0});
  plan.expected.emplace().chains.push_back({Millis{52.0}, {}, {}});
  const News told = news.in_force(plan);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].kind, "above-promise");
  EXPECT_NE(told[0].detail.find("a -> b: 52 ms, not 23.2 ms (it may be that " + plan::why_above_promise(plan, app)),
            std::string::npos)
      << told[0].detail;
  EXPECT_EQ(news.in_force(plan), News{});
  plan.expected->chains[0].response = Millis{23.3};
  EXPECT_EQ(news.in_force(plan).size(), 1U) << "that is over";
  EXPECT_EQ(news.in_force(plan), News{});
}

TEST(PlanNews, ALongListIsCutShort) {
  const graph::App app = two();
  PlanNews news(app);
  plan::Plan plan;
  plan.relax_factor = 2.0;
  for (int term = 0; term < 20; ++term) {
    plan.relaxed.push_back({"objective[" + std::to_string(term) + "].max", Millis{10}, Millis{20}});
  }
  const News told = news.in_force(plan);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_TRUE(told[0].detail.ends_with(" and 12 more")) << told[0].detail;
}

}  // namespace
}  // namespace ctn::driver
