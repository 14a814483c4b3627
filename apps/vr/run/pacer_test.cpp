#include "run/pacer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr Clock kDisplay{3ms, 8ms};
constexpr nanoseconds kLook = 500us;

TEST(Pacer, WakesOnceForEachTick) {
  Pacer pacer(kDisplay, kLook);
  std::vector<nanoseconds> ticks;
  for (nanoseconds now{}; now < 78ms; now += kLook) {
    if (pacer.due(now)) ticks.push_back(pacer.tick());
  }
  ASSERT_EQ(ticks.size(), 10U);
  for (std::size_t i = 0; i < ticks.size(); ++i) EXPECT_EQ(ticks[i], 3ms + static_cast<int>(i) * 8ms);
}

TEST(Pacer, BacksOffFastAndCreepsUpSlowly) {
  Pacer pacer(kDisplay, kLook);
  const nanoseconds before = pacer.lead();
  pacer.done(-1ns);
  const nanoseconds longer = pacer.lead();
  EXPECT_GT(longer, before);
  pacer.done(4ms);
  const nanoseconds shorter = pacer.lead();
  EXPECT_LT(shorter, longer);
  EXPECT_LT(longer - shorter, (longer - before) / 10);
  pacer.done(0ns);
  EXPECT_EQ(pacer.lead(), shorter) << "just in time";
}

TEST(Pacer, StaysWithinAPeriod) {
  Pacer pacer(kDisplay, kLook);
  for (int i = 0; i < 1000; ++i) pacer.done(-1ms);
  EXPECT_EQ(pacer.lead(), 8ms - kLook);
  for (int i = 0; i < 10'000; ++i) pacer.done(8ms);
  EXPECT_EQ(pacer.lead(), 0ns);
}

// What takes 1.2 ms comes to be woken as late as it can be, and misses no tick once it is.
TEST(Pacer, ComesCloseToTheDeadline) {
  Pacer pacer(kDisplay, kLook);
  nanoseconds least = 1s;
  nanoseconds most{};
  for (nanoseconds now{}; now < 40s; now += kLook) {
    if (!pacer.due(now)) continue;
    const nanoseconds spare = pacer.tick() - (now + 1200us);
    pacer.done(spare);
    if (now < 20s) continue;
    least = std::min(least, spare);
    most = std::max(most, spare);
  }
  EXPECT_GE(least, 0ns);
  EXPECT_LE(most, 8ms / 16 + kLook);
}

}  // namespace
}  // namespace ctn::vr::run
