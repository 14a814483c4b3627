#include "model/batch_estimator.h"

#include <gtest/gtest.h>

#include <random>

namespace ctn::model {
namespace {

// Runs of 1 ms and 0.5 ms an item, with some noise.
class BatchEstimatorTest : public ::testing::Test {
 protected:
  Nanos cost(std::size_t items, double fixed = 1.0, double per_item = 0.5) {
    const double noise = 1.0 + 0.05 * std::normal_distribution<double>()(random);
    return to_nanos(Millis{fixed * noise + per_item * static_cast<double>(items)});
  }
  std::size_t some(std::size_t min, std::size_t max) {
    return std::uniform_int_distribution<std::size_t>(min, max)(random);
  }
  // How often what is told has changed.
  int run(int count, std::size_t min, std::size_t max, double fixed = 1.0, double per_item = 0.5) {
    int changes = 0;
    for (int i = 0; i < count; ++i) {
      const std::size_t items = some(min, max);
      changes += estimator.add(cost(items, fixed, per_item), items, 0) ? 1 : 0;
    }
    return changes;
  }

  std::mt19937_64 random{1};
  BatchEstimator estimator;
};

TEST_F(BatchEstimatorTest, FindsWhatAnItemAdds) {
  run(20, 0, 4);
  EXPECT_NEAR(estimator.per_item().count(), 0.5, 0.05);
  run(200, 0, 4);
  EXPECT_NEAR(estimator.per_item().count(), 0.5, 0.01);
  EXPECT_NEAR(to_millis(estimator.without_items(to_nanos(Millis{3.0}), 4)).count(), 1.0, 0.04);
}

TEST_F(BatchEstimatorTest, BatchesThatAreAllAlikeTellNothing) {
  EXPECT_EQ(run(500, 3, 3), 0);
  EXPECT_EQ(estimator.per_item(), Millis{0});
}

TEST_F(BatchEstimatorTest, WhatIsKnownIsNotForgottenWhileBatchesAreAlike) {
  run(200, 0, 4);
  run(1000, 4, 4);
  EXPECT_NEAR(estimator.per_item().count(), 0.5, 0.01);
}

TEST_F(BatchEstimatorTest, RunsThatCostTheSameWithAnyBatchHaveNoCostPerItem) {
  EXPECT_EQ(run(2000, 0, 4, 1.0, 0.0), 0);
  EXPECT_EQ(estimator.per_item(), Millis{0});
}

TEST_F(BatchEstimatorTest, IsNeverBelowZero) {
  for (int i = 0; i < 200; ++i) {
    const std::size_t items = some(0, 4);
    estimator.add(to_nanos(Millis{5.0 - 0.5 * static_cast<double>(items)}), items, 0);
  }
  EXPECT_EQ(estimator.per_item(), Millis{0});
}

TEST_F(BatchEstimatorTest, SpikesDoNotCount) {
  for (int i = 0; i < 400; ++i) {
    const std::size_t items = some(0, 4);
    estimator.add(cost(items) + (i % 20 == 0 ? to_nanos(Millis{20.0}) : Nanos{0}), items, 0);
  }
  EXPECT_NEAR(estimator.per_item().count(), 0.5, 0.02);
}

TEST_F(BatchEstimatorTest, NoiseHardlyMovesWhatIsTold) {
  run(400, 2, 4);
  const Millis told = estimator.per_item();
  for (int i = 0; i < 50; ++i) {
    run(100, 2, 4);
    EXPECT_NEAR(estimator.per_item() / told, 1.0, 0.1);
  }
}

TEST_F(BatchEstimatorTest, AnItemThatAddsMoreIsFollowed) {
  run(400, 0, 4);
  run(400, 0, 4, 1.0, 1.0);
  EXPECT_NEAR(estimator.per_item().count(), 1.0, 0.05);
}

TEST_F(BatchEstimatorTest, EachModeHasAFixedPartOfItsOwn) {
  for (int i = 0; i < 400; ++i) {
    const std::size_t mode = some(0, 1);
    const std::size_t items = mode == 0 ? some(0, 2) : some(2, 4);
    estimator.add(cost(items, mode == 0 ? 1.0 : 9.0), items, mode);
  }
  EXPECT_NEAR(estimator.per_item().count(), 0.5, 0.1);
}

TEST_F(BatchEstimatorTest, LargerBatchesExplainLongerRuns) {
  run(100, 2, 2);
  run(6, 4, 4);
  EXPECT_EQ(estimator.per_item(), Millis{0});
  EXPECT_TRUE(estimator.explains(0, 6));
  EXPECT_NEAR(estimator.per_item().count(), 0.5, 0.05);
}

TEST_F(BatchEstimatorTest, BatchesThatAreAsLargeAsBeforeExplainNothing) {
  run(100, 2, 2);
  run(6, 2, 2, 3.0);
  EXPECT_FALSE(estimator.explains(0, 6));
  EXPECT_EQ(estimator.per_item(), Millis{0});
}

TEST_F(BatchEstimatorTest, WhatIsKnownOfItemsIsNotBlamedForMore) {
  run(400, 0, 4);
  run(6, 6, 6, 9.0);
  EXPECT_FALSE(estimator.explains(0, 6)) << "items would have to add far more than is known";
}

TEST_F(BatchEstimatorTest, FollowsTheSpeedOfItsCore) {
  run(200, 0, 4);
  const Millis told = estimator.per_item();
  estimator.rescale(2.0);
  EXPECT_EQ(estimator.per_item(), told * 2.0);
  run(200, 0, 4, 2.0, 1.0);
  EXPECT_NEAR(estimator.per_item().count(), 1.0, 0.02);
}

}  // namespace
}  // namespace ctn::model
