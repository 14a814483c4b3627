// What is drawn is the same everywhere, so every figure here is exact; the bounds are what the header and
// docs/decisions/0010-change-detection.md promise. The bench measures more of it.
#include "model/change_detector.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <functional>

#include "model/testing/change_detection_cases.h"

namespace ctn::model {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

// Alarms in so many runs.
std::uint64_t alarms_in(std::uint64_t runs, const std::function<Nanos(std::uint64_t)>& cost) {
  ChangeDetector detector;
  std::uint64_t alarms = 0;
  for (std::uint64_t run = 0; run < runs; ++run) alarms += detector.add(cost(run)) ? 1U : 0U;
  return alarms;
}

TEST(ChangeDetector, IsSeldomWrongWhateverTheDistribution) {
  constexpr std::uint64_t kRuns = 500'000;
  for (const Case& each : unchanging_cases()) {
    if (each.law.memory > 0.0) continue;
    const std::uint64_t alarms = alarms_in(kRuns, [draw = draws(each.law, 3)](std::uint64_t) { return draw(); });
    EXPECT_LE(alarms, kRuns / 50'000) << each.name;
  }
}

// Runs until a step after 100 runs is told, in the order of trials sorted by them.
std::vector<std::size_t> delays_of(const CaseLaw& law, double step) {
  std::vector<std::size_t> delays;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    ChangeDetector detector;
    const Draw draw = draws(law, trial);
    for (int run = 0; run < 100; ++run) detector.add(draw());
    std::size_t delay = 1;
    while (delay < 1000 && !detector.add(scaled(draw(), step))) ++delay;
    delays.push_back(delay);
  }
  std::sort(delays.begin(), delays.end());
  return delays;
}

TEST(ChangeDetector, TellsAStepByHalfWithinSomeTwentyRuns) {
  for (const double step : {1.5, 0.5}) {
    for (const CaseLaw& law :
         {CaseLaw{}, CaseLaw{.spread = 0.1}, CaseLaw{.spread = 0.25}, CaseLaw{.spread = 0.25, .spikes = 0.05}}) {
      const std::vector<std::size_t> delays = delays_of(law, step);
      EXPECT_LE(delays[delays.size() / 2], 22U) << step << ", spread " << law.spread << ", spikes " << law.spikes;
      EXPECT_LE(delays[delays.size() * 95 / 100], 50U) << step << ", spread " << law.spread;
    }
  }
}

TEST(ChangeDetector, RunsThatAreEachLikeTheLastRaiseFewAlarms) {
  for (const double memory : {0.5, 0.9}) {
    const Draw draw = draws({.spread = 0.25, .memory = memory}, 1);
    EXPECT_LE(alarms_in(100'000, [&](std::uint64_t) { return draw(); }), 100'000U / 100) << memory;
  }
}

TEST(ChangeDetector, SlowGrowthIsNoChange) {
  for (const double hertz : {5.0, 10.0, 100.0}) {
    const auto growing = [hertz](const Draw& draw) {
      return
          [draw, hertz](std::uint64_t run) { return scaled(draw(), 1.0 + 0.005 * static_cast<double>(run) / hertz); };
    };
    const auto runs = static_cast<std::uint64_t>(200.0 * hertz);
    EXPECT_EQ(alarms_in(runs, growing(draws({}, 1))), 0U) << hertz;
    EXPECT_EQ(alarms_in(runs, growing(draws({.spread = 0.25}, 1))), 0U) << hertz;
  }
}

TEST(ChangeDetector, SaysWhichRunsCameAfter) {
  ChangeDetector detector;
  for (int run = 0; run < 100; ++run) EXPECT_FALSE(detector.add(milliseconds{10}));
  std::size_t delay = 0;
  std::optional<std::size_t> told;
  while (!told) {
    ++delay;
    told = detector.add(milliseconds{20});
  }
  EXPECT_EQ(*told, delay);
  EXPECT_LE(delay, 12U);
  for (int run = 0; run < 1000; ++run) EXPECT_FALSE(detector.add(milliseconds{20})) << "that is how it is now";
}

TEST(ChangeDetector, SeldomMoreThanOneAlarmForOneStep) {
  std::uint64_t alarms = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Draw draw = draws({.spread = 0.25}, seed);
    alarms += alarms_in(1100, [&](std::uint64_t run) { return scaled(draw(), run < 100 ? 1.0 : 2.0); });
  }
  EXPECT_GE(alarms, 100U);
  EXPECT_LE(alarms, 105U);
}

TEST(ChangeDetector, WhatIsTooSmallToMatterIsNoChange) {
  EXPECT_EQ(alarms_in(1000, [](std::uint64_t run) { return Nanos{milliseconds{run < 500 ? 100 : 109}}; }), 0U);
  EXPECT_EQ(alarms_in(1000, [](std::uint64_t run) { return Nanos{microseconds{run < 500 ? 5 : 20}}; }), 0U);
  EXPECT_EQ(alarms_in(1000, [](std::uint64_t run) { return Nanos{milliseconds{run < 500 ? 100 : 112}}; }), 1U);
}

TEST(ChangeDetector, SpikesDoNotAddUp) {
  EXPECT_EQ(alarms_in(100'000, [](std::uint64_t run) { return Nanos{milliseconds{run % 5 == 0 ? 1000 : 10}}; }), 0U);
  const auto burst = [](std::uint64_t run) { return Nanos{milliseconds{run % 100 < 5 ? 1000 : 10}}; };
  EXPECT_EQ(alarms_in(100'000, burst), 0U) << "five in a row";
}

TEST(ChangeDetector, RescaledItExpectsWhatItWasScaledTo) {
  ChangeDetector detector;
  for (int run = 0; run < 60; ++run) detector.add(milliseconds{10});
  detector.rescale(2.0);
  for (int run = 0; run < 100; ++run) EXPECT_FALSE(detector.add(milliseconds{20}));
}

RC_GTEST_PROP(ChangeDetector, TellsAStepAndTheStepBack, ()) {
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1'000'000);
  const double step = static_cast<double>(*rc::gen::inRange(20, 50)) / 10.0;
  const Draw draw = draws({.spread = 0.1}, seed);
  std::vector<std::uint64_t> alarms;
  ChangeDetector detector;
  for (std::uint64_t run = 0; run < 300; ++run) {
    const bool high = run >= 100 && run < 200;
    if (detector.add(scaled(draw(), high ? step : 1.0))) alarms.push_back(run);
  }
  const auto told_within = [&](std::uint64_t begin, std::uint64_t end) {
    return std::any_of(alarms.begin(), alarms.end(), [&](std::uint64_t run) { return run >= begin && run < end; });
  };
  // Mostly it takes some 12 runs; the bounds are for the worst of a million draws.
  RC_ASSERT(told_within(100, 150));
  RC_ASSERT(told_within(200, 300));
}

}  // namespace
}  // namespace ctn::model
