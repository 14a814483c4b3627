#include "model/output_estimator.h"

#include <gtest/gtest.h>

namespace ctn::model {
namespace {

// Each `every`-th of so many runs gives an output.
void run(OutputEstimator& estimator, int every, int runs) {
  for (int number = 1; number <= runs; ++number) estimator.add(number % every == 0);
}

TEST(OutputEstimator, EachRunGivesAnOutputUnlessOneDoesNot) {
  OutputEstimator estimator;
  EXPECT_EQ(estimator.runs_per_output(), 1.0);
  run(estimator, 1, 10'000);
  EXPECT_EQ(estimator.runs_per_output(), 1.0);
}

TEST(OutputEstimator, TellsTheMeanOnceAFewOutputsAreKnown) {
  OutputEstimator estimator;
  run(estimator, 4, 20);  // five outputs: four gaps
  EXPECT_EQ(estimator.runs_per_output(), 1.0);
  run(estimator, 4, 4);
  EXPECT_EQ(estimator.runs_per_output(), 4.0);
}

TEST(OutputEstimator, WhatCameBeforeTheFirstOutputIsNoGap) {
  OutputEstimator estimator;
  for (int number = 0; number < 1000; ++number) estimator.add(false);
  run(estimator, 1, 100);
  EXPECT_EQ(estimator.runs_per_output(), 1.0);
}

TEST(OutputEstimator, ASkipNowAndThenChangesNothing) {
  OutputEstimator estimator;
  for (int number = 1; number <= 10'000; ++number) estimator.add(number % 30 != 0);
  EXPECT_EQ(estimator.runs_per_output(), 1.0);
}

TEST(OutputEstimator, ALastingChangeIsFollowedSoonAndWhatWasBeforeIsForgotten) {
  OutputEstimator estimator;
  run(estimator, 1, 10'000);
  run(estimator, 5, 60);  // some ten outputs
  EXPECT_EQ(estimator.runs_per_output(), 5.0);
  run(estimator, 1, 30);
  EXPECT_NEAR(estimator.runs_per_output(), 1.0, 0.1);
}

TEST(OutputEstimator, WhoGivesNoOutputAnyMoreKeepsWhatWasTold) {
  OutputEstimator estimator;
  run(estimator, 3, 300);
  for (int number = 0; number < 100'000; ++number) estimator.add(false);
  EXPECT_EQ(estimator.runs_per_output(), 3.0);
}

// Each run gives one by chance, of five on average: what is told does not wander with it.
TEST(OutputEstimator, ChanceIsNoReasonToTellAnythingElse) {
  int told = 0;
  double sum = 0.0;
  constexpr int kNodes = 100;
  for (int node = 0; node < kNodes; ++node) {
    std::minstd_rand random(static_cast<unsigned>(node + 1));
    OutputEstimator estimator;
    const auto run = [&](int runs) {
      for (int number = 0; number < runs; ++number) estimator.add(random() % 5 == 0);
    };
    run(1500);
    for (int turn = 0; turn < 200; ++turn) {
      const double before = estimator.runs_per_output();
      run(50);
      told += estimator.runs_per_output() != before ? 1 : 0;
    }
    sum += estimator.runs_per_output();
  }
  EXPECT_LT(told, 2 * kNodes) << "in 10 000 runs each, 2000 outputs";
  EXPECT_NEAR(sum / kNodes, 5.0, 0.25);
}

}  // namespace
}  // namespace ctn::model
