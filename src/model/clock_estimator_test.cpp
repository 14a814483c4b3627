#include "model/clock_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/mixed.h"

namespace ctn::model {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanos kNominal{8'333'333};

// A clock that is off by so many parts of a million.
struct Clock {
  double ppm = 0.0;
  TimePoint begin = TimePoint{} + milliseconds{3};

  double period() const { return static_cast<double>(kNominal.count()) * (1.0 + ppm * 1e-6); }
  TimePoint tick(int number) const { return begin + Nanos{std::llround(period() * number)}; }
};

// How far the estimate is from the clock's tick `number` in the future.
Nanos error_at(const ClockEstimator& estimator, const Clock& clock, int number) {
  const std::optional<Ticks> ticks = estimator.ticks();
  if (!ticks) return Nanos::max();
  const TimePoint tick = clock.tick(number);
  const Nanos late = ticks->next(tick) - tick;
  const Nanos early = tick - ticks->last(tick);
  return std::min(late, early);
}

// The first tick that NumbersTicksThroughGapsAndWindows tells of is number 0.
TimePoint estimator_origin(const Clock& clock) {
  int first = 0;
  while (mixed_of(3, first) % 3 == 0) ++first;
  return clock.tick(first);
}

TEST(ClockEstimator, SaysNothingOfFewTicks) {
  const Clock clock;
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < static_cast<int>(ClockEstimator::kMinTicks); ++number) {
    EXPECT_FALSE(estimator.ticks());
    estimator.add(clock.tick(number));
  }
  ASSERT_TRUE(estimator.ticks());
  EXPECT_EQ(estimator.ticks()->period, kNominal);
  EXPECT_LE(error_at(estimator, clock, 100), Nanos{100});
}

TEST(ClockEstimator, NumbersTicksThroughGapsAndWindows) {
  const Clock clock{.ppm = 40.0};
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 2000; ++number) {
    if (mixed_of(3, number) % 3 == 0) continue;
    estimator.add(clock.tick(number));
    const std::optional<Ticks> ticks = estimator.ticks();
    if (!ticks) continue;
    const TimePoint seventh = ticks->numbered(7);
    const auto told = std::lround(static_cast<double>((seventh - estimator_origin(clock)).count()) / clock.period());
    ASSERT_EQ(told % 7, 0) << number;
  }
}

// Nearly anywhere in its period.
TEST(ClockEstimator, SaysNothingOfWhatIsNotRegular) {
  const Clock clock;
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 300; ++number) {
    estimator.add(clock.tick(number) + chance_below(kNominal * 9 / 10, static_cast<std::uint64_t>(number), 1));
    EXPECT_FALSE(estimator.ticks()) << number;
  }
}

// Told up to 300 us late by chance, one in ten by up to 3 ms; one in seven is not told at all.
TEST(ClockEstimator, FindsPeriodAndPhaseThroughJitterAndGaps) {
  for (const double ppm : {-200.0, 0.0, 35.0}) {
    const Clock clock{.ppm = ppm};
    ClockEstimator estimator(kNominal);
    for (int number = 0; number < 1000; ++number) {
      if (mixed_of(7, number) % 7 == 0) continue;
      Nanos late = chance_below(microseconds{300}, static_cast<std::uint64_t>(number), 1);
      if (mixed_of(9, number) % 10 == 0) late = chance_below(milliseconds{3}, static_cast<std::uint64_t>(number), 2);
      estimator.add(clock.tick(number) + late);
    }
    ASSERT_TRUE(estimator.ticks()) << ppm;
    EXPECT_NEAR(static_cast<double>(estimator.ticks()->period.count()), clock.period(), 500.0) << ppm;
    // Half of them are 150 us late or more, which cannot be told from the phase.
    EXPECT_LE(error_at(estimator, clock, 1001), microseconds{250}) << ppm;
  }
}

// Told up to 300 us late by chance, one in a hundred by up to 3 ms: who waits for these waits 3 ms for one in a
// hundred.
TEST(ClockEstimator, WhoReadsArrivalsMissesFew) {
  const Clock clock{.ppm = 35.0};
  const auto told_at = [&](int number) {
    const bool seldom = mixed_of(9, number) % 100 == 0;
    return clock.tick(number) +
           chance_below(seldom ? Nanos{milliseconds{3}} : microseconds{300}, static_cast<std::uint64_t>(number), 1);
  };
  ClockEstimator estimator(kNominal, TicksAre::kArrivals);
  int read = 0;
  int missed = 0;
  for (int number = 0; number < 4000; ++number) {
    const std::optional<Ticks> ticks = number >= 300 ? estimator.ticks() : std::nullopt;
    if (ticks) {
      ++read;
      const TimePoint reads = ticks->next(clock.tick(number) - milliseconds{1});
      missed += told_at(number) > reads ? 1 : 0;
      ASSERT_LE(reads - clock.tick(number), microseconds{600}) << number;
    }
    estimator.add(told_at(number));
  }
  EXPECT_EQ(read, 3700);
  EXPECT_LE(missed, read / 40) << "half of them, by the middle";
}

TEST(ClockEstimator, WhatIsNeverToldLateIsReadAtTheTick) {
  const Clock clock;
  ClockEstimator estimator(kNominal, TicksAre::kArrivals);
  for (int number = 0; number < 300; ++number) estimator.add(clock.tick(number));
  EXPECT_LE(error_at(estimator, clock, 301), Nanos{100});
}

TEST(ClockEstimator, FollowsDrift) {
  ClockEstimator estimator(kNominal);
  TimePoint tick{};
  double period = static_cast<double>(kNominal.count());
  for (int number = 0; number < 20'000; ++number) {
    estimator.add(tick);
    tick += Nanos{std::llround(period)};
    period *= 1.0 + 1e-8;  // in three minutes from exact to 200 ppm slow
    if (number % 500 != 499) continue;
    ASSERT_TRUE(estimator.ticks());
    EXPECT_LE(tick - estimator.ticks()->last(tick + microseconds{20}), microseconds{20}) << number;
  }
}

TEST(ClockEstimator, OneThatIsAstrayChangesNothing) {
  const Clock clock;
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 200; ++number) {
    estimator.add(clock.tick(number));
    if (number % 20 == 19) estimator.add(clock.tick(number) + kNominal / 2);
  }
  EXPECT_EQ(estimator.ticks()->period, kNominal);
  EXPECT_LE(error_at(estimator, clock, 201), Nanos{100});
}

TEST(ClockEstimator, AClockThatIsSetAnewIsFoundAgain) {
  const Clock before;
  const Clock after{.ppm = 0.0, .begin = before.tick(200) + kNominal / 3};
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 200; ++number) estimator.add(before.tick(number));
  for (int number = 0; number < 60; ++number) estimator.add(after.tick(number));
  EXPECT_LE(error_at(estimator, after, 61), Nanos{100});
}

TEST(ClockEstimator, IsRightAfterALongPause) {
  const Clock clock{.ppm = 80.0};
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 200; ++number) estimator.add(clock.tick(number));
  for (int number = 50'000; number < 50'100; ++number) estimator.add(clock.tick(number));
  EXPECT_LE(error_at(estimator, clock, 50'101), Nanos{1000});
}

TEST(ClockEstimator, SaysNothingOfAnotherRate) {
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 300; ++number) estimator.add(TimePoint{} + number * milliseconds{11});
  EXPECT_FALSE(estimator.ticks());
}

TEST(ClockEstimator, TicksFromThePastArePassedOver) {
  const Clock clock;
  ClockEstimator estimator(kNominal);
  for (int number = 0; number < 100; ++number) {
    estimator.add(clock.tick(number));
    estimator.add(clock.tick(number));
    estimator.add(clock.tick(number) - seconds{1});
  }
  EXPECT_LE(error_at(estimator, clock, 101), Nanos{100});
}

}  // namespace
}  // namespace ctn::model
