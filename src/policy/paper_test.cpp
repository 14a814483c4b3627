#include "policy/paper.h"

#include <gtest/gtest.h>

#include <vector>

#include "config/testing/apps.h"
#include "plan/limits.h"

namespace ctn::policy {
namespace {

constexpr const char* kThree = R"(
catan: 1
app: three
nodes: { a: {}, b: {}, c: {} }
objective:
  - { period: a, weight: 1 }
  - { period: b, weight: 0.8 }
  - { period: c, weight: 0.6 }
)";

class PaperPolicyTest : public ::testing::Test {
 protected:
  model::CostTable costs_of(double a, double b, double c) const {
    model::CostTable costs(app.graph, Millis{0});
    const auto set = [&](const char* name, double cost) {
      costs.set(*app.graph.find_node(name), model::CostProfile::constant(Millis{cost}));
    };
    set("a", a);
    set("b", b);
    set("c", c);
    return costs;
  }
  Situation situation(const model::CostTable& costs, int periodic = 0) const {
    return {.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06, .periodic = periodic};
  }
  std::vector<std::vector<int>> cores(const Decision& decision) const {
    std::vector<std::vector<int>> all;
    for (const plan::SubchainPlan& subchain : decision.plan->subchains) all.push_back(subchain.cores);
    return all;
  }

  graph::App app = parse(kThree);
  os::CpuSet cpus{0, 1};
  PaperPolicy policy;
};

TEST_F(PaperPolicyTest, PlansEveryFiveSecondsAndCoresEveryTwenty) {
  EXPECT_EQ(policy.replan_every(app.scheduler), std::chrono::seconds{5});
  const model::CostTable first = costs_of(20.0, 2.0, 2.0);
  const Result<Decision> decision = policy.decide(situation(first));
  ASSERT_TRUE(decision.ok());
  // Now c is what is worth a core of its own.
  const model::CostTable other = costs_of(2.0, 2.0, 40.0);
  for (int periodic = 0; periodic <= 8; ++periodic) {
    SCOPED_TRACE(periodic);
    const auto again = policy.decide_again(situation(other, periodic), *decision);
    ASSERT_TRUE(again.ok() && *again);
    EXPECT_EQ(cores(**again) != cores(*decision), periodic % 4 == 0);
  }
}

TEST_F(PaperPolicyTest, PlansAnewForOtherCpus) {
  const model::CostTable costs = costs_of(20.0, 2.0, 2.0);
  const Result<Decision> decision = policy.decide(situation(costs));
  ASSERT_TRUE(decision.ok());
  cpus = os::CpuSet{1};
  const auto again = policy.decide_again(situation(costs, 1), *decision);
  ASSERT_TRUE(again.ok() && *again);
  EXPECT_EQ((*again)->plan->cores.size(), 1U);
}

TEST_F(PaperPolicyTest, FramesAreFixedAndOwnersKeepToTheirPeriod) {
  const model::CostTable costs = costs_of(20.0, 2.0, 2.0);
  const Result<Decision> decision = policy.decide(situation(costs));
  ASSERT_TRUE(decision.ok());
  for (const plan::CorePlan& core : decision->plan->cores) EXPECT_EQ(core.frames, graph::FrameMode::kFixed);
  for (std::size_t i = 0; i < 3; ++i) {
    if (plan::shares_core(*decision->plan, decision->plan->subchains[i])) continue;
    EXPECT_EQ(decision->assignment.places[i].pacing.after_completion, Nanos{0});
  }
}

constexpr const char* kDisplay = R"(
catan: 1
app: display
nodes: { show: { min_rate: 100Hz, max_rate: 100Hz }, other: {} }
objective: [ { period: show, weight: 1 }, { period: other, weight: 1 } ]
)";

TEST_F(PaperPolicyTest, AnExactRateThatCannotBeMetIsRelaxed) {
  app = parse(kDisplay);
  cpus = os::CpuSet{0};
  const model::CostTable costs(app.graph, Millis{20});
  const Result<Decision> decision = policy.decide(situation(costs));
  ASSERT_TRUE(decision.ok()) << decision.error().message();
  EXPECT_GT(decision->plan->relax_factor, 1.0);
  EXPECT_TRUE(plan::relaxes_exact_rates(*decision->plan, app));
}

TEST_F(PaperPolicyTest, CostsThatAreAssumedGiveWayToAnExactRate) {
  app = parse(kDisplay);
  cpus = os::CpuSet{0};
  const model::CostTable costs(app.graph, Millis{20});
  const std::vector<NodeId> assumed{NodeId(0), NodeId(1)};
  Situation guessed = situation(costs);
  guessed.assumed = assumed;
  const Result<Decision> decision = policy.decide(guessed);
  ASSERT_TRUE(decision.ok()) << decision.error().message();
  EXPECT_EQ(decision->plan->relax_factor, 1.0);
  ASSERT_EQ(decision->plan->assumed.size(), 2U);
  EXPECT_LT(decision->plan->assumed[0].cost, Millis{10});
}

}  // namespace
}  // namespace ctn::policy
