#include "model/idle_estimator.h"

#include <gtest/gtest.h>

#include <chrono>

#include "base/testing/times.h"

namespace ctn::model {
namespace {

using std::chrono::microseconds;

TEST(IdleEstimator, KnowsNothingOfFewRuns) {
  IdleEstimator estimator;
  for (std::size_t run = 1; run < IdleEstimator::kMinRuns; ++run) estimator.add(true, microseconds{30});
  EXPECT_EQ(estimator.idle(), IdleRuns{});
  estimator.add(true, microseconds{30});
  EXPECT_EQ(estimator.idle(), (IdleRuns{1.0, Millis{0.03}}));
}

TEST(IdleEstimator, RunsThatFindNothingNewAndGiveAnOutputAreNotIdle) {
  IdleEstimator estimator;
  for (int run = 0; run < 100; ++run) estimator.add(false, ms(5));
  EXPECT_EQ(estimator.idle(), IdleRuns{});
  for (int run = 0; run < 100; ++run) estimator.add(run % 4 != 0, run % 4 != 0 ? Nanos{microseconds{100}} : ms(5));
  EXPECT_NEAR(estimator.idle().part, 0.75, 0.1);
  EXPECT_EQ(estimator.idle().cost, Millis{0.1});
}

TEST(IdleEstimator, WhatIsToldMovesSeldomButFollows) {
  IdleEstimator estimator;
  for (int run = 0; run < 100; ++run) estimator.add(true, microseconds{100});
  for (int run = 0; run < 200; ++run) {
    estimator.add(true, microseconds(run % 2 == 0 ? 95 : 112));
    EXPECT_EQ(estimator.idle(), (IdleRuns{1.0, Millis{0.1}}));
  }
  for (int run = 0; run < 200; ++run) estimator.add(run % 2 == 0, microseconds{200});
  EXPECT_NEAR(estimator.idle().part, 0.5, 0.1);
  EXPECT_NEAR(estimator.idle().cost.count(), 0.2, 0.02);
  for (int run = 0; run < 100; ++run) estimator.add(false, microseconds{200});
  EXPECT_EQ(estimator.idle().part, 0.0);
}

}  // namespace
}  // namespace ctn::model
