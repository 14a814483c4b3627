#include "plan/recost.h"

#include <gtest/gtest.h>

#include "plan/testing/sample_plan.h"
#include "plan/validate.h"

namespace ctn::plan {
namespace {

TEST(Recost, AtTheSameCostsIsTheSamePlan) {
  const graph::App app = sample_app();
  const model::CostTable costs = sample_costs(app);
  Plan plan = sample_plan(app, costs);
  const std::optional<Plan> same = recost(plan, app, costs);
  ASSERT_TRUE(same);
  EXPECT_TRUE(validate(*same, app, costs, kSampleCores).ok());
  // Idle time that no rate cap asks for is not kept.
  EXPECT_NEAR(same->cores[0].frame.count(), 17.0 / 0.95, 1e-12);
  EXPECT_EQ(same->subchains[2], plan.subchains[2]);
}

TEST(Recost, KeepsWhoHasWhatAndMovesTheRest) {
  const graph::App app = sample_app();
  const Plan plan = sample_plan(app, sample_costs(app));
  model::CostTable costlier = sample_costs(app);
  costlier.set(*app.graph.find_node("map"), model::CostProfile::constant(Millis{60}));
  costlier.set(*app.graph.find_node("grab"), model::CostProfile::constant(Millis{30}));
  const std::optional<Plan> now = recost(plan, app, costlier);
  ASSERT_TRUE(now);
  const Status valid = validate(*now, app, costlier, kSampleCores);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
  EXPECT_DOUBLE_EQ(now->subchains[kSlow.index()].slice.count(), 15.0);
  EXPECT_NEAR(now->cores[0].frame.count(), (6.0 + 15.0 + 6.0) / 0.95, 1e-12);
  EXPECT_NEAR(now->subchains[kSee.index()].period.count(), 30.0 / 0.95, 1e-12);
  EXPECT_EQ(now->subchains[kSee.index()].cores, plan.subchains[kSee.index()].cores);
  EXPECT_GT(now->objective, plan.objective);
}

TEST(Recost, WaitsMakeRunsLongerAndTakeNoCpuTime) {
  const graph::App app = sample_app();
  const Plan before = recost(sample_plan(app, sample_costs(app)), app, sample_costs(app)).value();
  model::CostTable costs = sample_costs(app);
  costs.set_wait(*app.graph.find_node("map"), Millis{7});
  costs.set_wait(*app.graph.find_node("grab"), Millis{3});
  const std::optional<Plan> now = recost(before, app, costs);
  ASSERT_TRUE(now);
  const Status valid = validate(*now, app, costs, kSampleCores);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
  EXPECT_EQ(now->cores, before.cores);
  const SubchainPlan& slow = now->subchains[kSlow.index()];
  EXPECT_EQ(slow.wait, Millis{7});
  EXPECT_NEAR((slow.execution - before.subchains[kSlow.index()].execution).count(),
              7.0 + before.cores[0].frame.count() + 5.0, 1e-9);
  EXPECT_EQ(now->subchains[kFast.index()], before.subchains[kFast.index()]);
  EXPECT_NEAR((now->subchains[kSee.index()].execution - before.subchains[kSee.index()].execution).count(), 3.0, 1e-9);
  EXPECT_NEAR((now->chains[1].latency - before.chains[1].latency).count(), 3.0, 1e-9);
}

TEST(Recost, AWaitThatAPlanDoesNotKnowIsNamed) {
  const graph::App app = sample_app();
  const Plan plan = recost(sample_plan(app, sample_costs(app)), app, sample_costs(app)).value();
  model::CostTable costs = sample_costs(app);
  costs.set_wait(*app.graph.find_node("map"), Millis{7});
  const Status valid = validate(plan, app, costs, kSampleCores);
  ASSERT_FALSE(valid.ok());
  EXPECT_NE(valid.error().message().find("subchains.slow.wait_ms"), std::string::npos) << valid.error().message();
}

TEST(Recost, KeepsARateCap) {
  const graph::App app = sample_app();
  const Plan plan = sample_plan(app, sample_costs(app));
  const model::CostTable nothing(app.graph, Millis{0.001});
  const std::optional<Plan> now = recost(plan, app, nothing);
  ASSERT_TRUE(now);
  EXPECT_NEAR(now->cores[0].frame.count(), 10.0, 1e-12) << "fast runs at most 100 times a second";
}

TEST(Recost, AnExactRateOutOfReachIsSaid) {
  graph::AppSpec spec = sample_spec();
  node(spec, "detect").min_rate = node(spec, "detect").max_rate = graph::At<Rate>{Rate{50.0}, {}};
  const graph::App app = graph::build_app(spec).value();
  Plan plan = sample_plan(app, sample_costs(app));
  model::CostTable costlier = sample_costs(app);
  ASSERT_TRUE(recost(plan, app, costlier));
  EXPECT_DOUBLE_EQ(recost(plan, app, costlier)->subchains[kSee.index()].period.count(), 20.0);
  costlier.set(*app.graph.find_node("detect"), model::CostProfile::constant(Millis{40}));
  EXPECT_FALSE(recost(plan, app, costlier));
}

}  // namespace
}  // namespace ctn::plan
