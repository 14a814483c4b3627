#include "model/estimator.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <string>

#include "base/statistics.h"

namespace ctn::model {
namespace {

constexpr Nanos ms(int n) { return std::chrono::milliseconds{n}; }

TEST(Estimator, HasOneUnnamedModeWhereNoneIsDeclared) {
  Estimator estimator(50, 95.0, {});
  estimator.add({ms(3)}, 0);
  const CostProfile profile = estimator.profile();
  ASSERT_EQ(profile.modes().size(), 1U);
  EXPECT_EQ(profile.modes()[0], (ModeCost{"", 1.0, Millis{3}}));
}

TEST(Estimator, TakesThePercentileOfTheWindow) {
  Estimator estimator(20, 95.0, {});
  for (int i = 1; i <= 20; ++i) estimator.add({ms(i)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{19});
}

TEST(Estimator, ForgetsWhatLeftTheWindow) {
  Estimator estimator(10, 100.0, {});
  estimator.add({ms(1000)}, 0);
  for (int i = 0; i < 9; ++i) estimator.add({ms(1)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{1000});
  estimator.add({ms(1)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{1});
  EXPECT_EQ(estimator.count(), 11U);
}

TEST(Estimator, WeighsModesByHowOftenTheyOccur) {
  Estimator estimator(50, 95.0, {"skip", "match"});
  for (int i = 0; i < 8; ++i) estimator.add({ms(1)}, 0);
  for (int i = 0; i < 2; ++i) estimator.add({ms(9)}, 1);
  const CostProfile profile = estimator.profile();
  EXPECT_DOUBLE_EQ(profile.modes()[1].probability, 0.2);
  EXPECT_DOUBLE_EQ(profile.single_thread().count(), 2.6);
}

TEST(Estimator, ASampleHasModesAndRunsAsOftenAsTheyOccur) {
  Estimator estimator(10, 95, {"short", "long"});
  EXPECT_TRUE(estimator.sample().empty());
  for (int run = 0; run < 100; ++run) {
    const bool is_long = run % 5 == 0;
    estimator.add({ms(is_long ? 100 + run % 10 : 1)}, is_long ? 1 : 0);
  }
  const std::vector<RunTime> sample = estimator.sample();
  const auto longs = std::count_if(sample.begin(), sample.end(), [](RunTime run) { return run.cpu > ms(50); });
  EXPECT_NEAR(static_cast<double>(longs) / static_cast<double>(sample.size()), 0.2, 0.01);
  EXPECT_EQ(std::count(sample.begin(), sample.end(), RunTime{ms(100)}),
            std::count(sample.begin(), sample.end(), RunTime{ms(105)}));
}

TEST(Estimator, WhatRunsWaitIsAPercentileOfAllModesRuns) {
  Estimator estimator(20, 95.0, {"skip", "match"});
  EXPECT_EQ(estimator.wait(95.0), Millis{0});
  for (int run = 0; run < 40; ++run) {
    const bool match = run % 4 == 0;
    estimator.add({ms(1), match ? ms(8) : ms(0)}, match ? 1 : 0);
  }
  EXPECT_EQ(estimator.wait(95.0), Millis{8});
  EXPECT_EQ(estimator.wait(50.0), Millis{0});
  EXPECT_EQ(estimator.profile().single_thread(), Millis{1}) << "waits cost nothing";
  const std::vector<RunTime> sample = estimator.sample();
  const auto waits = std::count(sample.begin(), sample.end(), RunTime{ms(1), ms(8)});
  EXPECT_NEAR(static_cast<double>(waits) / static_cast<double>(sample.size()), 0.25, 0.01);
  estimator.rescale(2.0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{2});
  EXPECT_EQ(estimator.wait(95.0), Millis{8}) << "a device is no slower on a slower core";
}

TEST(Estimator, KeepsAPercentileOfARareMode) {
  Estimator estimator(5, 100.0, {"often", "rare"});
  estimator.add({ms(100)}, 1);
  for (int i = 0; i < 40; ++i) estimator.add({ms(1)}, 0);  // 8 windows later
  const CostProfile profile = estimator.profile();
  EXPECT_EQ(profile.modes()[1].cost, Millis{100});
  EXPECT_DOUBLE_EQ(profile.modes()[1].probability, 1.0 / 41.0);
}

TEST(Estimator, DropsTheFrequencyOfAModeThatStopped) {
  Estimator estimator(2, 100.0, {"before", "now"});
  for (int i = 0; i < 5; ++i) estimator.add({ms(100)}, 0);
  for (int i = 0; i < 20; ++i) estimator.add({ms(1)}, 1);
  EXPECT_EQ(estimator.profile().modes()[0].probability, 0.0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{1});
}

TEST(Estimator, CountsAnUnknownModeAsTheFirst) {
  Estimator estimator(5, 95.0, {"a", "b"});
  estimator.add({ms(7)}, 99);
  EXPECT_EQ(estimator.profile().modes()[0], (ModeCost{"a", 1.0, Millis{7}}));
  EXPECT_EQ(estimator.profile().modes()[1], (ModeCost{"b", 0.0, Millis{0}}));
}

// The definition, written out without the rings.
RC_GTEST_PROP(Estimator, AgreesWithItsDefinition, ()) {
  const int window = *rc::gen::inRange(1, 8);
  const double percentile = *rc::gen::element(1.0, 50.0, 95.0, 100.0);
  const auto runs = *rc::gen::nonEmpty(rc::gen::container<std::vector<std::pair<int, int>>>(
      rc::gen::pair(rc::gen::inRange(0, 3), rc::gen::inRange(0, 1'000'000))));
  Estimator estimator(window, percentile, {"a", "b", "c"});
  for (const auto& [mode, cpu] : runs) estimator.add({Nanos{cpu}}, static_cast<std::size_t>(mode));

  const CostProfile profile = estimator.profile();
  const std::size_t recent = std::min(runs.size(), static_cast<std::size_t>(window) * 10);
  for (int mode = 0; mode < 3; ++mode) {
    std::vector<double> samples;
    for (auto run = runs.rbegin(); run != runs.rend() && samples.size() < static_cast<std::size_t>(window); ++run) {
      if (run->first == mode) samples.push_back(to_millis(Nanos{run->second}).count());
    }
    std::sort(samples.begin(), samples.end());
    const auto often = std::count_if(runs.end() - static_cast<std::ptrdiff_t>(recent), runs.end(),
                                     [&](const auto& run) { return run.first == mode; });
    const ModeCost& estimated = profile.modes()[static_cast<std::size_t>(mode)];
    RC_ASSERT(estimated.cost.count() == (samples.empty() ? 0.0 : percentile_of_sorted(samples, percentile)));
    RC_ASSERT(estimated.probability == static_cast<double>(often) / static_cast<double>(recent));
  }
}

TEST(Estimator, ForgetsWhatWasBeforeAChange) {
  Estimator estimator(10, 100.0, {"a", "b"});
  estimator.add({ms(7)}, 1);
  for (int i = 0; i < 13; ++i) estimator.add({ms(10 + i)}, 0);
  for (int i = 0; i < 4; ++i) estimator.add({ms(40 + i)}, 0);
  const auto shift = estimator.forget_before(0, 4);
  ASSERT_TRUE(shift);
  EXPECT_EQ(shift->before, Millis{22});
  EXPECT_EQ(shift->after, Millis{43});
  estimator.add({ms(30)}, 0);
  EXPECT_EQ(estimator.profile(20.0).modes()[0].cost, Millis{30}) << "of five, the least";
  EXPECT_EQ(estimator.profile().modes()[0].cost, Millis{43});
  EXPECT_EQ(estimator.profile().modes()[1].cost, Millis{7}) << "the other mode has not changed";
  for (int i = 0; i < 10; ++i) estimator.add({ms(5)}, 0);
  EXPECT_EQ(estimator.profile().modes()[0].cost, Millis{5}) << "the window is as long as before";
}

TEST(Estimator, WhereTheWindowHoldsNothingElseThereIsNothingToForget) {
  Estimator estimator(4, 100.0, {});
  for (int i = 1; i <= 6; ++i) estimator.add({ms(i)}, 0);
  EXPECT_FALSE(estimator.forget_before(0, 4));
  estimator.add({ms(1)}, 0);
  estimator.add({ms(1)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{6});
  estimator.add({ms(1)}, 0);
  estimator.add({ms(1)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{1});
}

TEST(Estimator, Rescales) {
  Estimator estimator(4, 100.0, {});
  estimator.add({ms(6)}, 0);
  estimator.rescale(1.5);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{9});
}

TEST(Estimator, InvalidatedRunsServeUntilThereAreEnoughNewOnes) {
  Estimator estimator(40, 100.0, {});
  for (int i = 0; i < 40; ++i) estimator.add({ms(9)}, 0);
  estimator.invalidate();
  for (int i = 0; i < 4; ++i) estimator.add({ms(4)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{9});
  estimator.add({ms(4)}, 0);
  EXPECT_EQ(estimator.profile().single_thread(), Millis{4});
}

}  // namespace
}  // namespace ctn::model
