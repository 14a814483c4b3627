#include "runtime/starvation.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TimePoint at(Nanos offset) { return TimePoint{} + offset; }

TEST(Starvation, ALateTimerIsNone) {
  EXPECT_FALSE(woke_too_late(at(milliseconds{1}), at(milliseconds{5}), at(milliseconds{14})));
  EXPECT_TRUE(woke_too_late(at(milliseconds{1}), at(milliseconds{5}), at(milliseconds{15})));
  EXPECT_FALSE(woke_too_late(at(milliseconds{100}), at(milliseconds{5}), at(milliseconds{100}))) << "was due before";
}

TEST(Starvation, IsCountedAndTold) {
  Starvation starvation;
  EXPECT_FALSE(starvation.has_pending());
  EXPECT_FALSE(starvation.message(at(seconds{1})));
  starvation.woke_late(1, at(milliseconds{1000}), at(milliseconds{1050}));
  EXPECT_TRUE(starvation.has_pending());
  starvation.stolen_until_now({});
  EXPECT_FALSE(starvation.has_pending());
  EXPECT_EQ(starvation.times(), 1U);
  EXPECT_EQ(starvation.total(), milliseconds{50});
  const std::optional<std::string> message = starvation.message(at(seconds{2}));
  ASSERT_TRUE(message);
  EXPECT_EQ(message->find("CPU 1 was kept from real-time threads"), 0U) << *message;
  EXPECT_FALSE(starvation.message(at(seconds{2})));
}

TEST(Starvation, IsNotToldAgainAndAgain) {
  Starvation starvation;
  int told = 0;
  for (int second = 1; second <= 60; ++second) {
    starvation.woke_late(0, at(seconds{second}), at(seconds{second} + milliseconds{50}));
    starvation.stolen_until_now({});
    told += starvation.message(at(seconds{second})) ? 1 : 0;
  }
  EXPECT_EQ(told, 6);
  EXPECT_EQ(starvation.times(), 60U);
}

TEST(Starvation, ThreadsThatSeeTheSameCountOnce) {
  Starvation starvation;
  starvation.woke_late(0, at(milliseconds{1000}), at(milliseconds{1050}));
  starvation.woke_late(0, at(milliseconds{1010}), at(milliseconds{1050}));
  starvation.woke_late(1, at(milliseconds{1010}), at(milliseconds{1050}));
  starvation.stolen_until_now({});
  EXPECT_EQ(starvation.times(), 2U);
  EXPECT_EQ(starvation.total(), milliseconds{90});
}

TEST(Starvation, WhatTheHostTookIsNotTheKernels) {
  Starvation starvation;
  starvation.stolen_until_now({{0, milliseconds{500}}, {1, milliseconds{0}}});
  starvation.woke_late(0, at(milliseconds{1000}), at(milliseconds{1050}));
  starvation.woke_late(1, at(milliseconds{1000}), at(milliseconds{1050}));
  starvation.stolen_until_now({{0, milliseconds{550}}, {1, milliseconds{20}}});
  EXPECT_EQ(starvation.times(), 1U);
  EXPECT_EQ(starvation.total(), milliseconds{30});
  starvation.woke_late(0, at(milliseconds{2000}), at(milliseconds{2050}));
  starvation.stolen_until_now({{0, milliseconds{550}}, {1, milliseconds{20}}});
  EXPECT_EQ(starvation.times(), 2U) << "it took nothing since";
}

}  // namespace
}  // namespace ctn::runtime
