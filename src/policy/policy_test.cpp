#include "policy/policy.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "policy/planned.h"

namespace ctn::policy {
namespace {

Result<Decision> decided(const char* policy, const graph::App& app) {
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{2, 3};
  return (*make_policy(policy))->decide({.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06});
}

double rate(const Decision& decision) { return Rate::every(decision.assignment.places.front().pacing.period).hertz(); }

TEST(Policy, KnowsItsNames) {
  EXPECT_TRUE((*make_policy("catan"))->adapts());
  EXPECT_TRUE((*make_policy("catan"))->follows_plan());
  EXPECT_TRUE((*make_policy("fifo"))->raises());
  EXPECT_FALSE((*make_policy("fifo"))->follows_plan());
  EXPECT_FALSE((*make_policy("default"))->raises());
  for (const char* name : {"catan", "default", "fifo", "rate:12.5Hz"}) {
    EXPECT_EQ((*make_policy(name))->name(), name);
  }
}

TEST(Policy, SaysWhatWouldBeRight) {
  for (const char* text : {"", "catn", "static:", "fifo:", "rate:", "rate:-3", "rate:fast", "rate:0"}) {
    const auto policy = make_policy(text);
    ASSERT_FALSE(policy.ok()) << text;
    EXPECT_NE(policy.error().message().find("rate:12.5"), std::string::npos);
  }
}

TEST(CatanPolicy, DecidesAgainOnlyForAPlanThatIsBetter) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {}, c: {} }
edges: [ a -> b -> c ]
objective: [ { response_time: [a, b, c], weight: 1 } ]
)");
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{0, 1};
  const auto policy = *make_policy("catan");
  const Situation situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06};
  const auto first = policy->decide(situation);
  ASSERT_TRUE(first.ok());
  const double objective = first->plan->objective;
  const auto none = policy->decide_again(situation, *first, objective);
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(*none);
  for (const double to_beat : {1.001 * objective, std::numeric_limits<double>::infinity()}) {
    const auto replanned = policy->decide_again(situation, *first, to_beat);
    ASSERT_TRUE(replanned.ok());
    ASSERT_TRUE(*replanned);
    EXPECT_EQ((*replanned)->plan->objective, objective);
    EXPECT_TRUE((*replanned)->plan->expected);
  }
}

TEST(HandSetRates, TakeTheFallbackOrTheGivenRate) {
  const graph::App app = tracker_app();
  EXPECT_NEAR(rate(*decided("default", app)), 30.0, 1e-6);
  EXPECT_NEAR(rate(*decided("rate:8", app)), 8.0, 1e-6);
  EXPECT_FALSE(decided("default", app)->plan);
}

TEST(HandSetRates, NameEveryHeadThatHasNone) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {} }
edges: [ a -> b ]
objective: [ { response_time: [a, b], weight: 1 } ]
)");
  const auto all = decided("default", app);
  ASSERT_FALSE(all.ok());
  EXPECT_EQ(all.error().problems().size(), 2U);
  EXPECT_EQ(all.error().problems()[1].key, "nodes.b.fallback_rate");
  EXPECT_EQ(decided("rate:8", app).error().problems().size(), 1U) << "a is a source";
}

TEST(FixedPriorities, FollowTheOrderOfStealing) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: { fallback_rate: 10Hz }, b: { fallback_rate: 20Hz } }
edges: [ a -> b ]
objective: [ { response_time: [a, b], weight: 1 } ]
steal: { priority: [b, a], off: [] }
)");
  const Decision decision = *decided("fifo", app);
  const std::vector<SubchainPlace>& places = decision.assignment.places;
  EXPECT_EQ(places[app.graph.find_subchain("a")->index()].level, os::fixed_level(0));
  EXPECT_EQ(places[app.graph.find_subchain("b")->index()].level, os::fixed_level(1));
  EXPECT_EQ(places[0].cpus, (os::CpuSet{2, 3}));
  EXPECT_EQ(decision.unscheduled_level, os::fixed_level(2));
  EXPECT_EQ(decision.dispatcher_level, os::fixed_level(3));
}

TEST(Catan, PlansForTheCpusThatThereAre) {
  const Decision decision = *decided("catan", tracker_app());
  ASSERT_TRUE(decision.plan);
  EXPECT_TRUE(decision.plan->expected);
  EXPECT_EQ(decision.plan->cores.size(), 2U);
  EXPECT_EQ(decision.assignment.places.front().level, os::Level::kActive);
  EXPECT_EQ(decision.dispatcher_level, os::Level::kDispatcher);
}

TEST(AGivenPlan, IsFollowedWhateverItWouldBeNow) {
  const graph::App app = tracker_app();
  const Decision planned = *decided("catan", app);
  const StaticPolicy policy("static:plan.json", *planned.plan);
  EXPECT_EQ(policy.name(), "static:plan.json");
  EXPECT_TRUE(policy.follows_plan());
  EXPECT_FALSE(policy.adapts());
  const model::CostTable costs(app.graph, Millis{50});
  for (const os::CpuSet& cpus : {os::CpuSet{2, 3}, os::CpuSet{2}}) {
    const auto decision = policy.decide({.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06});
    EXPECT_EQ(decision.ok(), cpus.size() == 2) << "made for two cores";
    if (decision) {
      EXPECT_EQ(decision->plan, planned.plan);
    }
  }
}

}  // namespace
}  // namespace ctn::policy
