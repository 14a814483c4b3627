#include "plan/batches.h"

#include <gtest/gtest.h>

#include <cmath>

#include "plan/recost.h"
#include "plan/testing/sample_plan.h"
#include "plan/validate.h"

namespace ctn::plan {
namespace {

// log takes the outputs of map, and costs 4 ms and 1 ms for each.
class BatchesTest : public ::testing::Test {
 protected:
  const graph::App app = sample_app();
  const NodeId log = *app.graph.find_node("log");
  const model::CostTable before = sample_costs(app);
  const model::CostTable costs = [this] {
    model::CostTable table = before;
    table.set(log, model::CostProfile::constant(Millis{4}).with_per_item(Millis{1}));
    return table;
  }();
};

TEST_F(BatchesTest, APlanIsMadeForAsManyItemsAsItsPeriodsBring) {
  for (const Plan& plan : {sample_plan(app, before), sample_priorities(app, before)}) {
    const std::optional<Plan> now = recost(plan, app, costs);
    ASSERT_TRUE(now);
    ASSERT_EQ(now->batches.size(), 1U);
    EXPECT_EQ(now->batches[0].node, log);
    EXPECT_LE(needed_batches(*now, app, costs).value()[0].items, now->batches[0].items);
    const Millis cost = now->subchains[kBatch.index()].slice / now->subchains[kBatch.index()].share;
    EXPECT_DOUBLE_EQ(cost.count(), 4.0 + now->batches[0].items);
    const Status valid = validate(*now, app, costs, kSampleCores);
    EXPECT_TRUE(valid.ok()) << valid.error().message();
  }
}

// A run of batch may begin as soon as it is triggered, and the next be held up; outputs of map come every 40 ms.
TEST_F(BatchesTest, AFixedPriorityMayHoldARunUp) {
  const Plan plan = sample_priorities(app, before);
  const SubchainPlan& batch = plan.subchains[kBatch.index()];
  const Millis window = batch.period + batch.execution - batch.slice;
  const double outputs = std::ceil(window / Millis{40});
  EXPECT_EQ(needed_batches(plan, app, costs).value()[0].items, static_cast<int>(outputs) + 1);
}

TEST_F(BatchesTest, TooFewItemsAreNoticed) {
  Plan plan = recost(sample_plan(app, before), app, costs).value();
  --plan.batches[0].items;
  EXPECT_FALSE(validate(plan, app, costs, kSampleCores)) << "slices are of more";
  plan = sample_plan(app, before);
  const Status valid = validate(plan, app, costs, kSampleCores);
  ASSERT_FALSE(valid);
  EXPECT_NE(valid.error().message().find("log"), std::string::npos) << valid.error().message();
}

TEST_F(BatchesTest, WhereItemsCostNothingNothingIsSaid) {
  const std::optional<Plan> now = recost(sample_plan(app, before), app, before);
  ASSERT_TRUE(now);
  EXPECT_TRUE(now->batches.empty());
}

TEST_F(BatchesTest, AreEnlargedByLeapsIfNeedBe) {
  std::vector<Batch> batches{{log, 8}};
  EXPECT_FALSE(enlarge(batches, {{log, 8}}, 0));
  EXPECT_TRUE(enlarge(batches, {{log, 9}}, 0));
  EXPECT_EQ(batches[0].items, 9);
  EXPECT_TRUE(enlarge(batches, {{log, 10}}, 5));
  EXPECT_EQ(batches[0].items, 12);
  EXPECT_TRUE(enlarge(batches, {{log, 13}}, 9));
  EXPECT_EQ(batches[0].items, 24);
}

TEST_F(BatchesTest, WhatIsExpectedIsOfBatchesAsTheyCome) {
  const Plan plan = recost(sample_plan(app, before), app, costs).value();
  const model::CostTable mean = at_mean_batches(plan, app.graph, costs);
  const double items = plan.subchains[kBatch.index()].period / plan.subchains[kSlow.index()].period;
  EXPECT_DOUBLE_EQ(mean[log].single_thread().count(), 4.0 + items);
}

}  // namespace
}  // namespace ctn::plan
