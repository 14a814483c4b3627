#include "runtime/starvation.h"

#include <gtest/gtest.h>

#include "base/testing/times.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

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

// The kernel keeps a CPU from real-time threads for 50 ms at a time.
TEST(Starvation, AProcessThatWasStoppedIsNotStarved) {
  Starvation starvation;
  starvation.woke_late(0, at(milliseconds{1000}), at(milliseconds{4000}));
  EXPECT_FALSE(starvation.has_pending());
  starvation.woke_late(0, at(milliseconds{5000}), at(milliseconds{5249}));
  starvation.stolen_until_now({});
  EXPECT_EQ(starvation.times(), 1U) << "250 ms and more are a stop";
  EXPECT_EQ(starvation.total(), milliseconds{249});
}

// A thread that was to wake shortly before the process went on has waited only for that, whichever thread reports
// first.
TEST(Starvation, ThreadsThatWereDueWhileTheProcessWasStoppedAreNotStarved) {
  Starvation starvation;
  starvation.woke_late(1, at(milliseconds{3900}), at(milliseconds{4000}));
  starvation.woke_late(0, at(milliseconds{1000}), at(milliseconds{4001}));
  starvation.woke_late(2, at(milliseconds{3950}), at(milliseconds{4002}));
  starvation.stolen_until_now({});
  EXPECT_EQ(starvation.times(), 0U);
  starvation.woke_late(2, at(milliseconds{4002}), at(milliseconds{4051}));
  starvation.stolen_until_now({});
  EXPECT_EQ(starvation.total(), milliseconds{49}) << "the kernel kept the CPU after the process went on";
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
