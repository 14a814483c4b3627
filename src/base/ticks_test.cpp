#include "base/ticks.h"

#include <gtest/gtest.h>

namespace ctn {
namespace {

constexpr TimePoint at(std::int64_t nanos) { return TimePoint{Nanos{nanos}}; }

TEST(Ticks, AreTheNearestOnEitherSide) {
  constexpr Ticks ticks{at(103), Nanos{10}};
  EXPECT_EQ(ticks.next(at(103)), at(103));
  EXPECT_EQ(ticks.next(at(104)), at(113));
  EXPECT_EQ(ticks.next(at(113)), at(113));
  EXPECT_EQ(ticks.last(at(103)), at(103));
  EXPECT_EQ(ticks.last(at(112)), at(103));
  EXPECT_EQ(ticks.last(at(113)), at(113));
}

TEST(Ticks, GoOnBeforeTheOneThatIsKnown) {
  constexpr Ticks ticks{at(103), Nanos{10}};
  EXPECT_EQ(ticks.next(at(-4)), at(3));
  EXPECT_EQ(ticks.next(at(-7)), at(-7));
  EXPECT_EQ(ticks.last(at(2)), at(-7));
  EXPECT_EQ(ticks.last(at(-7)), at(-7));
  EXPECT_EQ(ticks.last(at(-8)), at(-17));
}

// Whatever the instant: no tick lies between it and what is said.
TEST(Ticks, LeaveNoneOut) {
  constexpr Ticks ticks{at(5), Nanos{7}};
  for (std::int64_t instant = -50; instant <= 50; ++instant) {
    const TimePoint next = ticks.next(at(instant));
    const TimePoint last = ticks.last(at(instant));
    EXPECT_EQ((next - ticks.tick) % ticks.period, Nanos{0});
    EXPECT_TRUE(next >= at(instant) && next < at(instant + 7)) << instant;
    EXPECT_TRUE(last <= at(instant) && last > at(instant - 7)) << instant;
    EXPECT_EQ(next == last, next == at(instant)) << instant;
  }
}

}  // namespace
}  // namespace ctn
